#pragma once

// Looks up a field at single places, to resolve the hits of particles. Places are in the field frame.

#include <cstdint>

#include "base/vec.h"
#include "methods/field/distance_field.h"

namespace scanmill {

// Returns the voxel size (m) of the level that serves the place.
double voxelAt(const DistanceField& field, const Vec3f& place);

// Returns the interpolated distance (voxels of the level); in an empty brick, a lower bound.
float distanceAt(const DistanceField& field, const Vec3f& place);

// Returns the triangle that the corner nearest to the place names, in a field without lists; kNoWord if no triangle is
// near.
std::uint32_t triangleAt(const DistanceField& field, const Vec3f& place);

}  // namespace scanmill
