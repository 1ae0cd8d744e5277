#include "pipeline/scenes/ego_vehicle.h"

#include <algorithm>
#include <memory>

namespace scanmill {

namespace {

constexpr std::uint32_t kRaysTogether = 1 << 16;  // about the number of rays that are traced at a time

// Sets a table to some rings of another.
void takeRings(const BeamTable& rays, std::uint32_t ring, std::uint32_t count, BeamTable& own) {
  own.rings = count;
  own.columns = rays.columns;
  own.raysPerBeam = rays.raysPerBeam;
  own.maxRange = rays.maxRange;
  own.period = rays.period;
  const auto take = [&](const auto& all, auto& some) {
    if (all.empty()) return;
    const std::size_t each = all.size() / rays.rings;
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(ring * each);
    some.assign(first, first + static_cast<std::ptrdiff_t>(count * each));
  };
  take(rays.elevation, own.elevation);
  take(rays.direction, own.direction);
  take(rays.origin, own.origin);
  take(rays.time, own.time);
}

}  // namespace

double BlockedRays::share() const {
  return static_cast<double>(blocked.size()) / static_cast<double>(range.size());
}

// Traces some rings at a time, since few rays hit the vehicle and only their hits are kept.
BlockedRays traceVehicle(const Method& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor) {
  BlockedRays found;
  found.range.reserve(rays.size());
  found.hits.reset(0, 0, Channels::all());
  Shot shot;
  shot.worldFromSensor = {vehicleFromSensor};
  const auto table = std::make_shared<BeamTable>();
  shot.beams = table;
  Hits some;
  const std::uint32_t together = std::max(1u, kRaysTogether / rays.columns);
  for (std::uint32_t ring = 0; ring < rays.rings; ring += together) {
    takeRings(rays, ring, std::min(together, rays.rings - ring), *table);
    vehicle.trace(shot, Channels::all(), some);
    const std::size_t before = found.range.size();
    found.range.insert(found.range.end(), some.range.begin(), some.range.end());
    for (std::size_t ray = 0; ray < some.rays(); ++ray) {
      if (!some.hit(ray)) continue;
      found.blocked.push_back(static_cast<std::uint32_t>(before + ray));
      forEachChannel([&](const ChannelRow&, auto member) {
        auto& column = found.hits.*member;
        column.push_back((some.*member)[ray]);
      });
    }
  }
  return found;
}

void blockByVehicle(const BlockedRays& vehicle, double minRange, Hits& hits) {
  hits.pathOfRay.assign(hits.rays(), RayPath::Direct);
  for (std::size_t i = 0; i < vehicle.blocked.size(); ++i) {
    const std::uint32_t ray = vehicle.blocked[i];
    const float range = vehicle.hits.range[i];
    if (range > hits.range[ray]) continue;
    const bool reported = !vehicle.dropped && range >= minRange;
    hits.range[ray] = reported ? range : kMiss;
    hits.pathOfRay[ray] = RayPath::EgoVehicle;
    forEachChannel([&](const ChannelRow& row, auto member) {
      auto& column = hits.*member;
      using Of = typename std::remove_reference_t<decltype(column)>::value_type;
      if (row.channel != Channel::Range && !column.empty()) column[ray] = reported ? (vehicle.hits.*member)[i] : Of{};
    });
    if (!hits.instance.empty()) hits.instance[ray] = 0;
    if (!hits.material.empty()) hits.material[ray] = reported ? kNoMaterial : 0;
    if (!hits.roughness.empty()) hits.roughness[ray] = 1;
    if (!hits.metallic.empty()) hits.metallic[ray] = 0;
    if (!hits.retroreflectance.empty()) hits.retroreflectance[ray] = 0;
  }
  // Rays that the vehicle blocks no longer count as unresolved.
  std::erase_if(hits.unresolved, [&](std::uint32_t ray) { return hits.pathOfRay[ray] == RayPath::EgoVehicle; });
}

}  // namespace scanmill
