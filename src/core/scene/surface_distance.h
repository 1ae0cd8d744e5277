#pragma once

// Horizontal distances of points from the surfaces of given classes.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

class SurfaceDistance {
 public:
  // Reads the triangles of these classes from all instances that are already in the scene, except moving instances.
  // Distances beyond `reach` (m) count as infinite.
  SurfaceDistance(const Scene& scene, const std::vector<std::uint16_t>& classes, double reach);

  // Returns the horizontal distance to the nearest triangle (m); 0 above or below a triangle; infinite beyond the
  // reach.
  double at(double x, double y) const;
  bool empty() const { return triangles_.empty(); }

 private:
  std::array<std::size_t, 2> cellOf(double x, double y) const;

  std::vector<std::array<Vec3d, 3>> triangles_;    // corners (m, world frame); only x and y are used
  std::vector<std::vector<std::uint32_t>> cells_;  // indices of the triangles whose boxes overlap a cell, by cell
  Vec3d low_;
  double side_ = 1;  // m, edge of a cell, at least the reach
  double reach_ = 0;
  std::size_t across_ = 0, along_ = 0;
};

}  // namespace scanmill
