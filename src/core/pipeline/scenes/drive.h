#pragma once

// Drives whose poses depend on the scene.

#include <memory>
#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"
#include "pipeline/scenes/scene_probe.h"

namespace scanmill {

// Whether a trajectory has poses only when its scene is known.
bool needsScene(const Trajectory& trajectory);

// It with the way and on the ground that it asks for, in the scene of a sequence. Throws InputError where the scene has
// none.
Trajectory inScene(const Trajectory& trajectory, const SceneProbe& probe, std::uint64_t seed);

}  // namespace scanmill
