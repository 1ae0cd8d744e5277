#pragma once

// Why a triangle cannot be traced.

#include <vector>

#include "scene/scene.h"

namespace scanmill {

// Counts in `dropped` why the triangle cannot be traced, and says whether it can.
bool canBeTraced(const Triangle& triangle, const std::vector<Vec3f>& positions, Dropped& dropped);

}  // namespace scanmill
