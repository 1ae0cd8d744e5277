#pragma once

// Loads the scenes of a pipeline for `scanmill plan --check` and reports faults in them.

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/scenes/shot_source.h"

namespace scanmill {

struct SceneFindings {
  std::vector<ModelledItem> modelled;  // the items of modelled(), then those of modelledOf() the scenes
  std::uint64_t bytes = 0;             // largest memory that the method takes for a scene; 0: not measured
};

// Prints a table of the scenes and their unlabelled geometry, and warns of legal but rarely intended contents: paths
// through things, objects of odd sizes, rules that match nothing. Loads only the first twenty scenes.
SceneFindings checkScenes(ShotSource& source);

}  // namespace scanmill
