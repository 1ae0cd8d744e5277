#pragma once

// Distances between point clouds.

#include <span>
#include <vector>

#include "base/vec.h"
#include "evaluate/spread.h"

namespace scanmill {

// Returns the spread of the distances (m) from each finite point of `from` to the nearest point of `to`. It is
// one-sided: points of `to` far from `from` do not show in it, so compare in both directions. Throws Error if `to` has
// no finite point.
Spread nearestDistances(std::span<const Vec3f> from, std::span<const Vec3f> to);

// Returns these distances themselves, in the order of the finite points of `from`.
std::vector<double> distancesToNearest(std::span<const Vec3f> from, std::span<const Vec3f> to);

}  // namespace scanmill
