#pragma once

// Computes the position and extent of a field from the user's options and the sensor's position.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "methods/field/distance_field.h"
#include "methods/particle/options.h"

namespace scanmill {

// Returns the levels around a sensor at `sensor` (m, relative to the world's origin), or the one level that holds
// `scene` (the scene's bounds in the same frame; empty if the scene has no triangles). The field should reach `range`
// (m). Depends on its arguments alone. Throws InputError, which says what to choose instead, if the field would have
// too many bricks.
FieldShape shapeOf(const ParticleOptions& options, const Vec3d& sensor, const Box& scene, double range);

// Returns about how many bytes a field of the scene takes. `scene`: its bounds, m, world frame.
double fieldBytes(const ParticleOptions& options, const Box& scene);

// Throws InputError, which says what to choose instead, if a scene-wide field would have too many bricks, or if the
// field is estimated to take more than twice `memory` (bytes). Twice, since the estimate may be off by that factor.
void checkField(const ParticleOptions& options, const Box& scene, double memory);

// Returns the box in which particles march: that of the outermost level, shrunk by a voxel (m, relative to the world's
// origin).
Box marchBox(const FieldShape& shape);

}  // namespace scanmill
