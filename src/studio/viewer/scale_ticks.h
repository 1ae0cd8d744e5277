#pragma once

// Computes the ticks and the title of a colour scale.

#include <string>
#include <vector>

#include "viewer/coloring.h"

namespace scanmill {

struct ScaleTick {
  double share = 0;  // position on the bar, from 0 at its low end to 1 at its high end
  std::string figure;
};

// Returns at most six ticks at multiples of 1, 2 or 5 times a power of ten; if the scale has no such value, at its
// ends. If the legend's values are integers, so are the ticks. A scale with a single value has one tick, in the middle.
std::vector<ScaleTick> scaleTicks(const Legend& legend);

// Returns the legend's title, with a remark if colours are not proportional to values or the user has chosen the ends,
// such as "range (m), by its square root".
std::string scaleTitle(const Legend& legend);

}  // namespace scanmill
