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

// Covers the square from -half to half (m) by the triangles of a quadtree's leaves. A cell of the tree is
// divided if its side is longer than `smallest` (m) and divided(), called with its centre and side, returns true.
Tiling makeTiling(double half, double smallest, const std::function<bool(double x, double y, double size)>& divided);

// Divides triangles along the line where a field is zero, so that no triangle has corners on both sides. `field`: value
// at each point (m), linear within each triangle; absolute values below 0.1 mm count as zero.
void cutAlong(Tiling& tiling, std::vector<double> field);

}  // namespace scanmill::town
