#pragma once

// Lanes of a scene's town, along which vehicles can drive. This header is installed because scenefile/scene_file.h
// includes it.
//
//   const std::optional<SceneLanes> lanes = readSceneLanes("scenes/town.yaml", 1);
//   const Vec3d start = lanes->lane.front();

#include <vector>

#include "base/vec.h"

namespace scanmill {

// Points on the road's surface, some metres apart (m, world frame).
struct SceneLanes {
  std::vector<Vec3d> lane;   // the main road's right-hand lane
  std::vector<Vec3d> turns;  // `lane` with turns from and into side roads, as far as the town has them
  int turnCount = 0;         // number of turns along `turns`
};

}  // namespace scanmill
