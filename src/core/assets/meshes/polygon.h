#pragma once

// Divides polygons into triangles.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/vec.h"

namespace scanmill {

// Divides the polygons of one file, within limits on the number of triangles and on the time. Polygons may be concave
// and only about planar: ears are cut off one by one (G. H. Meisters, "Polygons have ears", 1975) in the plane of the
// polygon's area vector. If no ear is left, since the polygon intersects itself or has no area, the rest is divided as
// a fan. The time grows with the square of the number of corners, for spirals with its cube.
class Triangulator {
 public:
  // `where`: the polygons' file, for messages. `mostTests`: largest number of comparisons of a corner with an ear, for
  // all polygons together; the default takes about ten seconds.
  explicit Triangulator(Location where, double mostTests = 2e9) : where_(std::move(where)), mostTests_(mostTests) {}

  // Returns the n - 2 triangles of a polygon with n corners (at least 3), as indices of corners, with the polygon's
  // orientation. They are valid until the next call. `corner` returns the position of a corner; it is not called if n
  // is 3. Throws InputError if the polygons so far exceed a limit.
  const std::vector<std::array<std::uint32_t, 3>>& divide(std::size_t n,
                                                          const std::function<Vec3d(std::size_t)>& corner);

 private:
  Location where_;
  double mostTests_;
  std::uint64_t allTriangles_ = 0;                       // number of triangles of all polygons so far
  double tests_ = 0;                                     // comparisons so far
  std::vector<Vec3d> polygon_;                           // the corners of the latest polygon
  std::vector<std::array<std::uint32_t, 3>> triangles_;  // triangles of the latest polygon
};

}  // namespace scanmill
