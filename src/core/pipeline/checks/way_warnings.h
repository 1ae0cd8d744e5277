#pragma once

// Warns of sensors and drives that are hardly where they were meant to be.

#include <string>
#include <vector>

#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

// Checks a sequence in its scene, with all objects where they are when the drive begins. Warns of sensors below the
// scene's surfaces, far above them or too far away from them, of sensors inside of objects, of paths through walls and
// of paths that leave the ground; at most once for each kind and sensor. Moving objects are not checked.
std::vector<std::string> wayWarnings(ShotSource& source, std::size_t sequence, const SceneProbe& probe);

}  // namespace scanmill
