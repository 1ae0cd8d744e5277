#pragma once

// Loads the scenes of a pipeline for `scanmill plan --check` and reports what is amiss in them.

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/scenes/shot_source.h"

namespace scanmill {

struct SceneFindings {
  std::vector<std::string> modelled;  // lines of modelled(), and those of the method in these scenes
  std::uint64_t bytes = 0;            // of the largest scene, in the form that the method has made of it
};

// Prints a table of the scenes and their unlabelled geometry, and warns of what is legal, but seldom meant: ways
// through walls, things of odd sizes, rules that match nothing. Loads each scene, the first twenty of them.
SceneFindings checkScenes(ShotSource& source);

}  // namespace scanmill
