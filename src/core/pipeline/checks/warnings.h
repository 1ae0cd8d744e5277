#pragma once

// What is legal, but seldom meant.

#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"
#include "scene/scene.h"

namespace scanmill {

// Objects whose size tells of a wrong unit: more than 5 km or less than 1 mm. A line per mesh, the first few of them.
std::vector<std::string> sizeWarnings(const Scene& scene);

// Triangles of damaged meshes, which are left out: corners that are no finite numbers, or that are not there.
std::vector<std::string> damageWarnings(const Scene& scene);

// Things that are far smaller or larger than what labels/words.yaml has as usual for their classes: a bus of 12 cm, a
// tree of 2 km. The first few of them.
std::vector<std::string> thingSizeWarnings(const Scene& scene);

// How many triangles no rule gives a class.
std::vector<std::string> unlabeledWarnings(const Scene& scene);

// Rules that match nothing, or nothing that rules before them have not decided; and files in which all things of a
// class are one, though their nodes are many.
std::vector<std::string> ruleWarnings(const Scene& scene);

// A line where classes were to be taken out that the scene does not have (scene/without.h).
std::vector<std::string> withoutWarnings(const Scene& scene);

// The seeds of a scene of which nothing follows from a seed: its sequences differ in nothing.
std::vector<std::string> seedWarnings(const Pipeline& pipeline, const Sequence& sequence, const Scene& scene);

// Drives that were to turn in towns where they cannot, and recorded ones that can hardly be meant.
std::vector<std::string> driveWarnings(const Pipeline& pipeline);

// Sensors that see little but their own vehicle: a line each. `blocked`: see ShotSource::blockedShares().
std::vector<std::string> vehicleWarnings(const Pipeline& pipeline, const std::vector<double>& blocked);

}  // namespace scanmill
