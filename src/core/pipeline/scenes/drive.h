#pragma once

// Computes trajectories that depend on the scene: random paths and heights above the ground.

#include <memory>
#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"
#include "pipeline/scenes/scene_probe.h"
#include "sensors/trajectory.h"

namespace scanmill {

// True if the trajectory's poses can only be computed when its scene is loaded.
bool needsScene(const Trajectory& trajectory);

// Returns the trajectory with its random path, and with its poses moved onto the ground, as far as the trajectory asks
// for these. Both are found in the scene of `probe`. `seed`: determines the random path. Throws InputError if the scene
// has no suitable path or ground.
Trajectory inScene(const Trajectory& trajectory, const SceneProbe& probe, std::uint64_t seed);

}  // namespace scanmill
