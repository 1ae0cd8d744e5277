#pragma once

#include <string>

#include "base/vec.h"

namespace scanmill {

// Returns the edges of a box along x, y and z in m, such as "4.01 x 2.14 x 1.57 m", or "-" if the box is empty. Edges
// have three significant digits; from 100 m on they are whole metres.
std::string extentText(const Box& box);

}  // namespace scanmill
