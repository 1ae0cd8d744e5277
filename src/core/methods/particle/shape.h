#pragma once

// Computes the position and extent of a field from the user's options and the sensor's position.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "methods/field/distance_field.h"
#include "methods/particle/options.h"

namespace scanmill {

// Returns the shape of a field that reaches `range` (m) around a sensor at `sensor` (m, relative to the world's
// origin), but not farther than `scene` (the scene's bounds in the same frame; empty if the scene has no triangles).
// Depends only on its arguments. Throws InputError, with advice, if the field would have too many bricks.
FieldShape shapeOf(const ParticleOptions& options, const Vec3d& sensor, const Box& scene, double range);

// Returns approximately how many bytes a field takes.
double fieldBytes(const ParticleOptions& options);

// Throws InputError, with advice, if the estimated size of a field is more than twice `memory` (bytes). The limit is
// twice the memory because the estimate may be wrong by this factor.
void checkField(const ParticleOptions& options, double memory);

// Returns the box inside of which particles march: the box of the outermost level, shrunk by a voxel (m, relative to
// the world's origin).
Box marchBox(const FieldShape& shape);

}  // namespace scanmill
