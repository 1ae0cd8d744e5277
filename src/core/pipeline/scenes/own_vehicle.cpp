#include "pipeline/scenes/own_vehicle.h"

#include <memory>
#include <vector>

#include "methods/method.h"

namespace scanmill {

namespace {

// Sets a table to one ring of another.
void takeRing(const BeamTable& rays, std::uint32_t ring, BeamTable& own) {
  own.rings = 1;
  own.columns = rays.columns;
  own.raysPerBeam = rays.raysPerBeam;
  own.maxRange = rays.maxRange;
  own.period = rays.period;
  const auto take = [&](const auto& all, auto& some) {
    if (all.empty()) return;
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(std::size_t{ring} * rays.columns);
    some.assign(first, first + rays.columns);
  };
  take(rays.direction, own.direction);
  take(rays.origin, own.origin);
  take(rays.time, own.time);
}

}  // namespace

double BlockedRays::share() const {
  return static_cast<double>(blocked.size()) / static_cast<double>(range.size());
}

// Traces ring by ring, since few rays hit the vehicle and only their hits are kept.
BlockedRays traceVehicle(const Scene& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor) {
  const auto method = makeReference(vehicle);
  BlockedRays found;
  found.range.reserve(rays.size());
  found.hits.reset(0, 0, Channels::all());
  Shot shot;
  shot.worldFromSensor = {vehicleFromSensor};
  const auto table = std::make_shared<BeamTable>();
  shot.beams = table;
  Hits ringHits;
  for (std::uint32_t ring = 0; ring < rays.rings; ++ring) {
    takeRing(rays, ring, *table);
    method->trace(shot, Channels::all(), ringHits);
    const std::size_t before = found.range.size();
    found.range.insert(found.range.end(), ringHits.range.begin(), ringHits.range.end());
    for (std::size_t ray = 0; ray < ringHits.rays(); ++ray) {
      if (!ringHits.hit(ray)) continue;
      found.blocked.push_back(static_cast<std::uint32_t>(before + ray));
      forEachChannel([&](const ChannelRow&, auto member) {
        auto& column = found.hits.*member;
        column.push_back((ringHits.*member)[ray]);
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
    const bool reported = range >= minRange;
    hits.range[ray] = reported ? range : kMiss;
    hits.pathOfRay[ray] = RayPath::OwnVehicle;
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
  std::erase_if(hits.unresolved, [&](std::uint32_t ray) { return hits.pathOfRay[ray] == RayPath::OwnVehicle; });
}

}  // namespace scanmill
