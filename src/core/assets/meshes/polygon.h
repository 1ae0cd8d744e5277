#pragma once

// Divides polygons into triangles.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Appends the n - 2 triangles of a polygon with n corners, three at least, as indices of corners. The triangles have
// the polygon's orientation. The polygon may be concave and only about planar: ears are cut off one by one (G. H.
// Meisters, "Polygons have ears", 1975) in the plane of the polygon's area vector. If no ear is left, since the polygon
// intersects itself or has no area, the rest is divided as a fan. The time grows with the square of n, for spirals with
// its cube: adds to `tests` how many times a corner was compared with an ear. Returns false, with triangles missing, if
// `tests` exceeds 2e9, which takes about ten seconds, or would exceed it if each corner that is tried were an ear.
bool triangulate(std::span<const Vec3d> corners, std::vector<std::array<std::uint32_t, 3>>& triangles, double& tests);

// Divides the polygons of one file, within limits of the number of triangles and of the time that it takes.
class Triangulator {
 public:
  explicit Triangulator(std::filesystem::path file) : file_(std::move(file)) {}

  // Returns the triangles of a polygon with n corners, three at least; they are valid until the next call. `corner` is
  // called only if there are more than three. Throws InputError if the polygons so far exceed a limit.
  const std::vector<std::array<std::uint32_t, 3>>& divide(std::size_t n,
                                                          const std::function<Vec3d(std::size_t)>& corner);

 private:
  std::filesystem::path file_;
  std::uint64_t divided_ = 0;  // number of triangles so far
  double tests_ = 0;           // see triangulate()
  std::vector<Vec3d> polygon_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
};

}  // namespace scanmill
