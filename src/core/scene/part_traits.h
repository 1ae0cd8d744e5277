#pragma once

// What rules may tell the triangles of one part of an asset from each other by.

#include <cstddef>
#include <vector>

#include "scene/assets/asset.h"
#include "scene/rules.h"

namespace scanmill {

class PartTraits {
 public:
  // The part is kept by reference. `lowest` is the asset's lowest point (m). Sizes of connected parts, which take time,
  // are found only where they are wanted: triangles are connected where corners are at the same place.
  PartTraits(const AssetPart& part, double lowest, bool withSizes);

  TriangleTraits at(std::size_t triangle) const;

 private:
  Rgb colorAt(const Triangle& triangle) const;

  const AssetPart& part_;
  double lowest_;
  std::vector<double> sizes_;  // by triangle
};

}  // namespace scanmill
