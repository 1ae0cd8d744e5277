#pragma once

// Where a field lies, from what a user asks for and where the sensor is.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "methods/field/distance_field.h"
#include "methods/particle/options.h"

namespace scanmill {

// Levels around a sensor at `sensor` (m, relative to the world's origin), or the one level that holds `scene` (the
// scene's bounds, likewise; empty: a scene without triangles). `range`: m, so far should the field reach. Depends on
// its arguments alone. Throws InputError where a scene-wide field would have too many bricks, and says what would do.
FieldShape shapeOf(const ParticleOptions& options, const Vec3d& sensor, const Box& scene, double range);

// About how many bytes a field of the scene takes. `scene`: its bounds, m, world frame.
double fieldBytes(const ParticleOptions& options, const Box& scene);

// Throws InputError where a scene-wide field would have too many bricks, or where the field would take more than twice
// the memory (bytes), and says what would do. Twice, since the estimate may be off by that factor.
void checkField(const ParticleOptions& options, const Box& scene, double memory);

// The outermost level's box, shrunk by a voxel (m, relative to the world's origin). Particles march inside of it.
Box marchBox(const FieldShape& shape);

}  // namespace scanmill
