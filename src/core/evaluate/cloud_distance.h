#pragma once

// Distances between point clouds.

#include <span>
#include <vector>

#include "base/vec.h"
#include "evaluate/spread.h"

namespace scanmill {

// From each finite point of `from` to the nearest of `to` (m). One-sided: what `to` has beyond `from` does not show, so
// look both ways. Throws Error where `to` has no finite point.
Spread nearestDistances(std::span<const Vec3f> from, std::span<const Vec3f> to);

// The distances themselves, in the order of the finite points.
std::vector<double> distancesToNearest(std::span<const Vec3f> from, std::span<const Vec3f> to);

}  // namespace scanmill
