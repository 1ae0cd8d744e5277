#pragma once

// The ego vehicle ("own vehicle" in manifests and among causes), which carries the sensors and blocks some of their
// beams.

#include <cstdint>
#include <functional>
#include <vector>

#include "base/vec.h"
#include "methods/interface/method.h"
#include "scan/hits.h"
#include "sensors/beams.h"

namespace scanmill {

// The rays of a sensor that hit the vehicle which carries the sensor. They are the same for all shots, since sensor and
// vehicle move together, unless the sensor's beams differ from revolution to revolution.
struct BlockedRays {
  bool dropped = false;                // true: these rays give no return, as drivers leave the vehicle out
  std::vector<float> range;            // m, by ray of the sensor; kMiss: the ray does not hit the vehicle
  std::vector<std::uint32_t> blocked;  // indices of the rays that hit it, ascending
  Hits hits;                           // the hits of these rays, in the same order

  // Traces the beams of another revolution; null if the sensor's beams are the same in all revolutions.
  std::function<BlockedRays(const BeamTable& beams)> ofRevolution{};

  double share() const;  // the fraction of the rays that hit the vehicle
};

// Traces the rays of a sensor's beam table to the vehicle at any distance, even below the sensor's minimum range.
// `vehicle`: a method that traces the vehicle's scene, which is in the vehicle's frame.
BlockedRays traceVehicle(const Method& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor);

// Replaces each hit behind the vehicle, and each miss of a ray that hits the vehicle, by the hit on the vehicle, with
// path EgoVehicle, no instance, no material and a matt surface. If this hit is nearer than the sensor's minimum range
// `minRange` (m), or if `vehicle.dropped` is true, it becomes a miss with path EgoVehicle. `vehicle` and `hits` must
// have the same rays.
void blockByVehicle(const BlockedRays& vehicle, double minRange, Hits& hits);

}  // namespace scanmill
