#pragma once

// Completes trajectories whose poses depend on the scene.

#include <memory>
#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"
#include "pipeline/scenes/scene_probe.h"

namespace scanmill {

// True if a trajectory has no poses until its scene is known.
bool needsScene(const Trajectory& trajectory);

// Returns the trajectory with the random path and on the ground that it asks for, both found in the probe's scene.
// Throws InputError if the scene has no such path or ground.
Trajectory inScene(const Trajectory& trajectory, const SceneProbe& probe, std::uint64_t seed);

}  // namespace scanmill
