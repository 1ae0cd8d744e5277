#pragma once

// Tests whether a triangle can be traced.

#include <vector>

#include "scene/scene.h"

namespace scanmill {

// True if the triangle can be traced; otherwise counts the reason in `dropped`.
[[nodiscard]] bool canBeTraced(const Triangle& triangle, const std::vector<Vec3f>& positions, Dropped& dropped);

}  // namespace scanmill
