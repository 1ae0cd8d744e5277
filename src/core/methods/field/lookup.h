#pragma once

// Looks up a field at single points, to resolve the hits of particles. Points are in the field frame.

#include <cstdint>

#include "base/vec.h"
#include "methods/field/distance_field.h"

namespace scanmill {

// Returns the voxel size (m) of the level that is used at a point.
double voxelAt(const DistanceField& field, const Vec3f& place);

// Returns the triangle stored at the corner nearest to a point, in a field without lists; kNoWord if no triangle is
// near.
std::uint32_t triangleAt(const DistanceField& field, const Vec3f& place);

}  // namespace scanmill
