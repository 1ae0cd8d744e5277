#pragma once

// What stands beside the bar of a scale.

#include <string>
#include <vector>

#include "viewer/coloring.h"

namespace scanmill {

struct ScaleTick {
  double share = 0;  // of the bar, from its low end
  std::string figure;
};

// At round values: 1, 2 or 5 times a power of ten, and their multiples; whole ones where the values are. Never more
// than six. One value alone stands in the middle.
std::vector<ScaleTick> scaleTicks(const Legend& legend);

// What the scale is of, and how it runs: "range (m), by its square root".
std::string scaleTitle(const Legend& legend);

}  // namespace scanmill
