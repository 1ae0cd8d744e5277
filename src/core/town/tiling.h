#pragma once

// Triangles that cover a square without gaps or overlaps; they are finer where needed and can be cut along lines.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "models/models.h"

namespace scanmill::town {

using models::Point2;

// Counter-clockwise triangles without T-junctions: edges inside the square belong to exactly two triangles.
struct Tiling {
  std::vector<Point2> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Covers the square from -half to half by a quadtree, whose leaves become triangles around their centres. A square with
// this size and centre (x, y) is divided while divided() is true and the size is above `smallest` (m).
Tiling makeTiling(double half, double smallest, const std::function<bool(double x, double y, double size)>& divided);

// Divides triangles along the line on which a field (m; by point, linear within each triangle) is zero, so that none
// has corners on both sides. A corner is on the line if the absolute value of its field is below 0.1 mm.
void cutAlong(Tiling& tiling, std::vector<double> field);

}  // namespace scanmill::town
