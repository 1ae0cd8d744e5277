#include "pipeline/scenes/own_vehicle.h"

#include <memory>
#include <vector>

#include "methods/method.h"

namespace scanmill {

Hits traceVehicle(const Scene& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor) {
  auto near = std::make_shared<BeamTable>(rays);
  near->minRange = 0;
  Shot shot;
  shot.beams = std::move(near);
  shot.worldFromSensor = {vehicleFromSensor};
  const auto method = makeReference(vehicle);
  Hits hits;
  method->trace(shot, Channels::all(), hits);
  return hits;
}

double blockedShare(const Hits& vehicle) {
  std::uint64_t blocked = 0;
  for (std::size_t ray = 0; ray < vehicle.rays(); ++ray) blocked += vehicle.hit(ray) ? 1 : 0;
  return static_cast<double>(blocked) / static_cast<double>(vehicle.rays());
}

void blockByVehicle(const Hits& vehicle, double minRange, Hits& hits) {
  hits.pathOfRay.assign(hits.rays(), RayPath::Direct);
  for (std::size_t ray = 0; ray < vehicle.rays(); ++ray) {
    if (!vehicle.hit(ray) || vehicle.range[ray] > hits.range[ray]) continue;
    const bool reported = vehicle.range[ray] >= minRange;
    hits.range[ray] = reported ? vehicle.range[ray] : kMiss;
    hits.pathOfRay[ray] = RayPath::OwnVehicle;
    forEachChannel([&](const ChannelRow& row, auto member) {
      auto& column = hits.*member;
      using Of = typename std::remove_reference_t<decltype(column)>::value_type;
      if (row.channel != Channel::Range && !column.empty()) column[ray] = reported ? (vehicle.*member)[ray] : Of{};
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
