#include <algorithm>
#include <memory>

#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

constexpr std::uint32_t kRaysAtOnce = 1 << 16;  // about the number of rays that are traced at a time

// Sets `part` to the rings of a table from `firstRing` on, so many as `count`.
void copyRings(const BeamTable& table, std::uint32_t firstRing, std::uint32_t count, BeamTable& part) {
  part.rings = count;
  part.columns = table.columns;
  part.raysPerBeam = table.raysPerBeam;
  part.maxRange = table.maxRange;
  part.period = table.period;
  const auto copy = [&](const auto& values, auto& partValues) {  // empty, or several values per ring
    if (values.empty()) return;
    const std::size_t perRing = values.size() / table.rings;
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(firstRing * perRing);
    partValues.assign(first, first + static_cast<std::ptrdiff_t>(count * perRing));
  };
  copy(table.elevation, part.elevation);
  copy(table.direction, part.direction);
  copy(table.origin, part.origin);
  copy(table.time, part.time);
}

}  // namespace

double BlockedRays::share() const {
  return static_cast<double>(blocked.size()) / static_cast<double>(range.size());
}

// Traces some rings at a time, since few rays hit the vehicle and only their hits are kept.
BlockedRays traceVehicle(const Method& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor) {
  BlockedRays blocked;
  blocked.range.reserve(rays.size());
  blocked.hits.reset(0, 0, Channels::all());
  Shot shot;
  shot.worldFromSensor = {vehicleFromSensor};
  const auto table = std::make_shared<BeamTable>();
  shot.beams = table;
  Hits hits;
  const std::uint32_t ringsAtOnce = std::max(1u, kRaysAtOnce / rays.columns);
  for (std::uint32_t ring = 0; ring < rays.rings; ring += ringsAtOnce) {
    copyRings(rays, ring, std::min(ringsAtOnce, rays.rings - ring), *table);
    vehicle.trace(shot, Channels::all(), hits);
    const std::size_t firstRay = blocked.range.size();
    blocked.range.insert(blocked.range.end(), hits.range.begin(), hits.range.end());
    for (std::size_t ray = 0; ray < hits.rays(); ++ray) {
      if (!hits.hit(ray)) continue;
      blocked.blocked.push_back(static_cast<std::uint32_t>(firstRay + ray));
      forEachChannel([&](const ChannelRow&, auto member) { (blocked.hits.*member).push_back((hits.*member)[ray]); });
    }
  }
  return blocked;
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
      using Element = typename std::remove_reference_t<decltype(column)>::value_type;
      if (row.channel != Channel::Range && !column.empty())
        column[ray] = reported ? (vehicle.hits.*member)[i] : Element{};
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
