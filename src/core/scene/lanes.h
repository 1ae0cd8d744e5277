#pragma once

// Paths through the towns of scenes that vehicles can drive along.

#include <vector>

#include "base/vec.h"

namespace scanmill {

// Points on the road's surface, some metres apart (m, world frame).
struct SceneLanes {
  std::vector<Vec3d> lane;   // the main road's right-hand lane
  std::vector<Vec3d> turns;  // from a side road into that lane, and from the lane into another side road, if they exist
  int turnCount = 0;         // number of turns along `turns`
};

}  // namespace scanmill
