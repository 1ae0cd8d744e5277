#pragma once

// The ego vehicle ("own vehicle" in messages), which carries the sensors and blocks some of their beams.

#include <filesystem>

#include "base/vec.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/beams.h"

namespace scanmill {

// Returns the hit of each ray of a sensor's beam table on the vehicle that carries the sensor, at any distance, even
// below the sensor's minimum range. The hits are the same for all shots, since sensor and vehicle move together.
// `vehicle`: a scene in the vehicle's frame.
Hits traceVehicle(const Scene& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor);

// Returns the fraction of the rays that hit the vehicle.
double blockedShare(const Hits& vehicle);

// Replaces each hit behind the vehicle, and each miss of a ray that hits the vehicle, by the hit on the vehicle, with
// path OwnVehicle, no instance, no material and a matt surface. If this hit is nearer than the sensor's minimum range
// `minRange` (m), it becomes a miss with path OwnVehicle. `vehicle` and `hits` must have the same rays.
void blockByVehicle(const Hits& vehicle, double minRange, Hits& hits);

}  // namespace scanmill
