#pragma once

// Ways through the towns of scenes that vehicles can drive.

#include <vector>

#include "base/vec.h"

namespace scanmill {

// Places on the road's surface some metres apart (m, world).
struct SceneLanes {
  std::vector<Vec3d> lane;   // the main road's right-hand lane
  std::vector<Vec3d> turns;  // out of a side road into that lane, and from it into another, as far as there are any
  int turnCount = 0;         // of `turns`
};

}  // namespace scanmill
