#pragma once

// The vehicle that carries the sensors: it hides sectors of their lowest rings.

#include <filesystem>

#include "base/vec.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/beams.h"

namespace scanmill {

// What each ray of a sensor's table meets of its own vehicle, however near. The same in all shots: sensor and vehicle
// move together. `vehicle`: a scene in the vehicle's frame.
Hits traceVehicle(const Scene& vehicle, const BeamTable& rays, const Pose& vehicleFromSensor);

// The share of the rays that the vehicle is in the way of.
double blockedShare(const Hits& vehicle);

// Puts the vehicle in front of what the rays meet otherwise: where it is nearer, the ray meets the vehicle (path
// OwnVehicle, no instance, no material, which is matt), or nothing where that is nearer than the sensor's least range
// `minRange` (m). Both tables are of the same rays.
void blockByVehicle(const Hits& vehicle, double minRange, Hits& hits);

}  // namespace scanmill
