#pragma once

// Sensors and drives that are not where they were meant to be.

#include <string>
#include <vector>

#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

// Of a sequence in its scene, as it stands when the drive begins: sensors under its surfaces, far above them or
// too far away from them, sensors inside of things, ways that go through walls, and ways that leave the ground. A line
// each, at most one of a kind and sensor. What moves is not looked at.
std::vector<std::string> wayWarnings(ShotSource& source, std::size_t sequence, const SceneProbe& probe);

}  // namespace scanmill
