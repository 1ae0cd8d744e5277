#pragma once

// Triangles that cover a square without gaps or overlaps, small where that is asked for, and cut along lines.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "models/models.h"

namespace scanmill::town {

using models::Point2;

// Counter-clockwise triangles. Every edge but those of the square's border belongs to exactly two: there are no
// T-junctions, so that no beam slips through.
struct Tiling {
  std::vector<Point2> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Covers the square from -half to half by a quadtree whose leaves are fans about their centres. A square of the side
// `size` about a point is divided while divided(x, y, size) is true and its side is above `smallest` (m).
Tiling makeTiling(double half, double smallest, const std::function<bool(double x, double y, double size)>& divided);

// Divides triangles along the line on which a field, given at the tiling's points, is zero, straight within each
// triangle: afterwards no triangle has corners on both sides. Corners within a tenth of a millimetre of zero lie on the
// line.
void cutAlong(Tiling& tiling, const std::function<double(std::uint32_t point)>& field);

}  // namespace scanmill::town
