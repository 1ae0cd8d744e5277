#pragma once

// What rules may tell the triangles of one part of an asset from each other by.

#include <cstddef>
#include <vector>

#include "assets/asset.h"
#include "scenefile/rules.h"

namespace scanmill {

// Where the frame of an asset's parts lies.
struct PartFrame {
  Vec3d origin;       // m, in the asset's frame
  double lowest = 0;  // m, the lowest point of all parts, less the origin
};

class PartTraits {
 public:
  // The part is kept by reference. Sizes of connected parts, which take time, are found only where they are wanted:
  // triangles are connected where corners are at the same place.
  PartTraits(const AssetPart& part, const PartFrame& frame, bool withSizes);

  TriangleTraits at(std::size_t triangle) const;

 private:
  Rgb colorAt(const Triangle& triangle) const;

  const AssetPart& part_;
  PartFrame frame_;
  std::vector<double> sizes_;  // by triangle
};

}  // namespace scanmill
