#pragma once

#include <string>

#include "base/vec.h"

namespace scanmill {

// Returns the edges of a box along x, y and z in m, to three digits: "4.01 x 2.14 x 1.57 m"; "-" if it is empty.
std::string extentText(const Box& box);

}  // namespace scanmill
