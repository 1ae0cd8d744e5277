#pragma once

// How far places are from the surfaces of certain classes, as seen from above.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

class SurfaceDistance {
 public:
  // Takes all triangles of these classes that are placed in the scene so far, but for what moves. Distances beyond
  // `reach` (m) are not told apart.
  SurfaceDistance(const Scene& scene, const std::vector<std::uint16_t>& classes, double reach);

  // Horizontal, to the nearest of the triangles (m); 0 above and below one; infinite beyond the reach.
  double at(double x, double y) const;
  bool empty() const { return triangles_.empty(); }

 private:
  std::array<std::size_t, 2> cellOf(double x, double y) const;

  std::vector<std::array<Vec3d, 3>> triangles_;    // of which x and y count
  std::vector<std::vector<std::uint32_t>> cells_;  // the triangles whose boxes are in a cell
  Vec3d low_;
  double side_ = 1;  // m, of a cell, at least the reach
  double reach_ = 0;
  std::size_t across_ = 0, along_ = 0;
};

}  // namespace scanmill
