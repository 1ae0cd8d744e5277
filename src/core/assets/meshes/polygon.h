#pragma once

// Divides polygons into triangles.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Appends the n - 2 triangles of a polygon with n corners, three at least, as indices of corners. The triangles have
// the polygon's orientation. The polygon may be concave and only about planar: ears are cut off one by one (G. H.
// Meisters, "Polygons have ears", 1975) in the plane of the polygon's area vector. If no ear is left, since the polygon
// intersects itself or has no area, the rest is divided as a fan. The time grows with the square of n, for spirals with
// its cube.
void triangulate(std::span<const Vec3d> corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace scanmill
