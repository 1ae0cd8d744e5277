#pragma once

// Distances between point clouds.

#include <span>
#include <vector>

#include "base/vec.h"
#include "evaluate/spread.h"

namespace scanmill {

// Returns the spread of the distances (m) from each finite point of `from` to the nearest point of `to`. The result is
// one-sided: it does not show points of `to` that are far from all points of `from`, so compute it in both directions.
// Throws Error if `to` has no finite point.
Spread nearestDistances(std::span<const Vec3f> from, std::span<const Vec3f> to);

// Returns the distance (m) from each finite point of `from` to the nearest point of `to`, in the order of `from`.
std::vector<double> distancesToNearest(std::span<const Vec3f> from, std::span<const Vec3f> to);

}  // namespace scanmill
