#pragma once

// Triangles that cover a square without gaps or overlaps, finer where needed, and cut along lines.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "models/models.h"

namespace scanmill::town {

using models::Point2;

// Counter-clockwise triangles. Every edge, except on the square's border, belongs to exactly two triangles: without
// T-junctions no ray passes between them.
struct Tiling {
  std::vector<Point2> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Covers the square from -half to half by a quadtree whose leaves are divided into triangles around their centres. A
// square of the side `size` about (x, y) is divided further while divided(x, y, size) is true and `size` is above
// `smallest` (m).
Tiling makeTiling(double half, double smallest, const std::function<bool(double x, double y, double size)>& divided);

// Divides triangles along the line on which a field is zero. The field (m) is given at the tiling's points and is
// linear within each triangle; afterwards no triangle has corners on both sides of the line. Corners where the field is
// within a tenth of a millimetre of zero count as on the line.
void cutAlong(Tiling& tiling, const std::function<double(std::uint32_t point)>& field);

}  // namespace scanmill::town
