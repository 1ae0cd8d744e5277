#pragma once

// Properties of triangles that rules can test.

#include <cstddef>
#include <vector>

#include "assets/asset.h"
#include "scenefile/rules.h"

namespace scanmill {

// The frame in which the positions of an asset's parts are given.
struct PartFrame {
  Vec3d origin;       // m, origin of this frame in the asset's frame
  double lowest = 0;  // m, least z of the points of all parts, in this frame
};

class PartTraits {
 public:
  // Keeps a reference to `part`. Only if `withSizes` is true, computes the sizes of connected parts, which is slow; see
  // connect().
  PartTraits(const AssetPart& part, const PartFrame& frame, bool withSizes);

  TriangleTraits at(std::size_t triangle) const;

 private:
  Rgb colorAt(const Triangle& triangle) const;

  const AssetPart& part_;
  PartFrame frame_;
  std::vector<double> sizes_;  // m, by triangle: the longest edge of the box around its connected part; empty without
                               // `withSizes`
};

}  // namespace scanmill
