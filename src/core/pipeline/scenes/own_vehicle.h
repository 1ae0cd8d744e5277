#pragma once

// The vehicle that carries the sensors: it occludes sectors of their lowest rings.

#include <filesystem>

#include "base/vec.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/beams.h"

namespace scanmill {

// Returns the hit of each ray of a sensor's beam table on its own vehicle, however near. All shots have the same hits,
// since sensor and vehicle move together. `vehicle`: a scene in the vehicle's frame.
Hits traceVehicle(const Scene& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor);

// Returns the share of the rays that hit the vehicle.
double blockedShare(const Hits& vehicle);

// Replaces each hit that lies behind the vehicle by the ray's hit on the vehicle (path OwnVehicle, no instance, no
// material, matt), or by a miss if the vehicle is nearer than the sensor's least range `minRange` (m). Both tables have
// the same rays.
void blockByVehicle(const Hits& vehicle, double minRange, Hits& hits);

}  // namespace scanmill
