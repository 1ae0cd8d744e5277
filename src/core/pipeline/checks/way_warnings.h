#pragma once

// Warns of sensors and drives that are probably not where the user intended.

#include <string>
#include <vector>

#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

// Checks a sequence in its scene, with all objects at their positions at time 0 s. Warns of sensors below the scene's
// surfaces, far above them or beyond their range, of sensors inside of objects, of paths through walls and of paths
// that leave the ground. Gives each kind of warning at most once per sensor. Moving objects are not checked.
std::vector<std::string> wayWarnings(ShotSource& source, std::size_t sequence, const SceneProbe& probe);

}  // namespace scanmill
