#pragma once

#include "methods/field/distance_field.h"

namespace scanmill {

// Whether particles read the same of both, wherever each keeps its bricks.
bool sameField(const DistanceField& a, const DistanceField& b);

}  // namespace scanmill
