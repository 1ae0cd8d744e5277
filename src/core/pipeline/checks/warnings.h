#pragma once

// Warnings about scenes and pipelines that are valid, but probably not what the user intended.

#include <cstddef>
#include <string>
#include <vector>

#include "base/vec.h"
#include "pipeline/plan/plan.h"
#include "scene/scene.h"

namespace scanmill {

class SceneProbe;
class ShotSource;

// Warns of meshes whose size suggests a wrong unit: larger than 5 km or smaller than 1 mm or, for meshes that are a
// single thing such as a car, larger than 300 m or smaller than 1 cm. Returns one line per mesh: at most five lines
// and, if there are more such meshes, a line with the number of the other meshes.
std::vector<std::string> sizeWarnings(const Scene& scene);

// Warns of damaged meshes, in which triangles were left out because a corner is not finite or does not exist.
std::vector<std::string> damageWarnings(const Scene& scene);

// Warns of triangles that get a class neither from a rule nor from their file, and states their number.
std::vector<std::string> unlabeledWarnings(const Scene& scene);

// Warns of labelling rules without effect: rules that match nothing, or only triangles that earlier rules have
// labelled. Also warns of meshes of at least 30 m that are one object instance although three or more nodes have the
// same class.
std::vector<std::string> ruleWarnings(const Scene& scene);

// Warns if the pipeline removes classes from the scene (takeOut() in scene/scene.h) that the scene does not have.
std::vector<std::string> withoutWarnings(const Scene& scene);

// Warns if a scene is used with several seeds although nothing in it is procedural: its geometry is then the same for
// all seeds.
std::vector<std::string> seedWarnings(const Pipeline& pipeline, const Sequence& sequence, const Scene& scene);

// Warns if all drives with `along: turns` are straight (a single straight drive is normal), if a recorded drive is
// implausible, and if the time between frames is shorter than the slowest sensor's revolution.
std::vector<std::string> driveWarnings(const Pipeline& pipeline);

// Warns of values that effects assume because a sensor's file does not give them, and of effects that the pipeline
// lists for a sensor but does not apply.
std::vector<std::string> sensorWarnings(const Plan& plan);

// Warns of a sensor if at least half of its rays hit the ego vehicle. `blocked`: result of ShotSource::blockedShares().
std::vector<std::string> vehicleWarnings(const Pipeline& pipeline, const std::vector<double>& blocked);

// Checks a sequence in its scene, with all objects at their positions at time 0 s. Warns of sensors that are on or
// below surfaces, farther from the scene than their range, or enclosed by surfaces of one class; of the
// first object that the vehicle's box goes through; and of paths that leave the ground. Ignores moving objects around
// sensors and in the vehicle's way. Gives each kind of warning at most once per sensor or path.
std::vector<std::string> pathWarnings(ShotSource& source, std::size_t sequence, const SceneProbe& probe);

}  // namespace scanmill
