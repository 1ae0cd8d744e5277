#pragma once

// Warns of sensors and drives that are probably not where the user intended.

#include <string>
#include <vector>

#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

// Checks a sequence in its scene, with all objects at their positions at time 0 s. Warns of sensors that are on or
// below surfaces, far above them, farther from the scene than their range, or inside of objects or of surfaces of one
// class, of vehicles whose box goes through objects, and of paths that leave the ground. Moving objects count neither
// for the box nor around a sensor. Gives each kind of warning at most once per sensor or path.
std::vector<std::string> wayWarnings(ShotSource& source, std::size_t sequence, const SceneProbe& probe);

}  // namespace scanmill
