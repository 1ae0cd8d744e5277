#pragma once

// Distances between point clouds.

#include <span>
#include <vector>

#include "base/vec.h"
#include "evaluate/spread.h"

namespace scanmill {

// How the distances (m) from each finite point of `from` to the nearest point of `to` spread. They are one-sided: what
// `to` has beyond `from` does not show, so look both ways. Throws Error where `to` has no finite point.
Spread nearestDistances(std::span<const Vec3f> from, std::span<const Vec3f> to);

// The same distances themselves, in the order of the finite points of `from`.
std::vector<double> distancesToNearest(std::span<const Vec3f> from, std::span<const Vec3f> to);

}  // namespace scanmill
