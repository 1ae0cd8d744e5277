#pragma once

// The ticks and the title of a colour scale's bar.

#include <string>
#include <vector>

#include "viewer/coloring.h"

namespace scanmill {

struct ScaleTick {
  double share = 0;  // 0 to 1: position on the bar, from its low end
  std::string figure;
};

// Returns at most six ticks at round values: multiples of 1, 2 or 5 times a power of ten; whole numbers if the legend's
// values are whole. A scale with a single value has one tick, in the middle.
std::vector<ScaleTick> scaleTicks(const Legend& legend);

// Returns the quantity of the scale and how colours follow it: "range (m), by its square root".
std::string scaleTitle(const Legend& legend);

}  // namespace scanmill
