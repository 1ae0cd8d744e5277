#pragma once

// Warnings about scenes and pipelines that are legal, but seldom meant so.

#include <string>
#include <vector>

#include "pipeline/read/pipeline.h"
#include "scene/scene.h"

namespace scanmill {

// Warns of objects whose size hints at a wrong unit: more than 5 km or less than 1 mm. A line for each mesh, the first
// few alone.
std::vector<std::string> sizeWarnings(const Scene& scene);

// Warns of triangles of damaged meshes, which are left out: their corners are not finite numbers, or do not exist.
std::vector<std::string> damageWarnings(const Scene& scene);

// Warns of object instances far smaller or larger than the usual size of their class in labels/words.yaml: a bus of
// 12 cm, a tree of 2 km. The first few alone.
std::vector<std::string> thingSizeWarnings(const Scene& scene);

// Warns of triangles to which no rule gives a class, with their number.
std::vector<std::string> unlabeledWarnings(const Scene& scene);

// Warns of rules without effect, which match nothing or only triangles that earlier rules have decided; and of files in
// which all nodes of a class are one instance, though they are many.
std::vector<std::string> ruleWarnings(const Scene& scene);

// Warns if classes are to be taken out of the scene (scene/without.h) that it does not have.
std::vector<std::string> withoutWarnings(const Scene& scene);

// Warns if a scene has several seeds though nothing in it is procedural: the geometry is then the same for all seeds.
std::vector<std::string> seedWarnings(const Pipeline& pipeline, const Sequence& sequence, const Scene& scene);

// Warns of drives that should turn in a town without a turn, and of recorded drives that can hardly be meant so.
std::vector<std::string> driveWarnings(const Pipeline& pipeline);

// Warns of each sensor that sees little but its own vehicle. `blocked`: see ShotSource::blockedShares().
std::vector<std::string> vehicleWarnings(const Pipeline& pipeline, const std::vector<double>& blocked);

}  // namespace scanmill
