#pragma once

// Looks a field up at single places, for what particles have met. Places are in the field frame.

#include <cstdint>

#include "base/vec.h"
#include "methods/field/distance_field.h"

namespace scanmill {

// m, of the voxels of the level that serves the place.
double voxelAt(const DistanceField& field, const Vec3f& place);

// Interpolated, voxels of the level; in an empty brick a lower bound.
float distanceAt(const DistanceField& field, const Vec3f& place);

// The triangle nearest to the corner that is nearest to the place, of a field without lists; kNoWord where none is
// near.
std::uint32_t triangleAt(const DistanceField& field, const Vec3f& place);

}  // namespace scanmill
