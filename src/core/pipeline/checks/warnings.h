#pragma once

// Warnings about scenes and pipelines that are valid, but probably not what the user intended.

#include <string>
#include <vector>

#include "pipeline/plan/plan.h"
#include "scene/scene.h"
#include "scene/thing_boxes.h"

namespace scanmill {

// Warns of meshes whose size suggests a wrong unit: more than 5 km or less than 1 mm. Returns one line per mesh: at
// most five lines, then a line with the number of those left out.
std::vector<std::string> sizeWarnings(const Scene& scene);

// Warns of damaged meshes, in which triangles were left out because a corner is not finite or does not exist.
std::vector<std::string> damageWarnings(const Scene& scene);

// Warns of object instances far smaller or larger than usual for their class (labels/words.yaml), such as a bus of 12
// cm. Returns one line per mesh and class: at most five lines, then a line with the number of those left out.
std::vector<std::string> thingSizeWarnings(const Scene& scene);

// Returns a warning for each vehicle model whose front is not on the side that the scene file states: at most five
// lines, then a line with the number of those left out. Checks object instances whose heading is known and whose class
// has wheels according to labels/words.yaml. A heading counts as wrong if the box's width exceeds 1.1 times its length,
// or if the vehicle drives sideways. `boxes`: the bounding boxes of the scene's objects.
std::vector<std::string> headingWarnings(const Scene& scene, const ThingBoxes& boxes);

// Warns of triangles to which no rule gives a class, and states their number.
std::vector<std::string> unlabeledWarnings(const Scene& scene);

// Warns of labelling rules without effect: rules that match nothing, or only triangles that earlier rules have
// labelled. Also warns of meshes of at least 30 m that are one object instance although three or more nodes have the
// same class.
std::vector<std::string> ruleWarnings(const Scene& scene);

// Warns if the pipeline removes classes from the scene (scene/without.h) that the scene does not have.
std::vector<std::string> withoutWarnings(const Scene& scene);

// Warns if a scene is used with several seeds although nothing in it is procedural: its geometry is then the same for
// all seeds.
std::vector<std::string> seedWarnings(const Pipeline& pipeline, const Sequence& sequence, const Scene& scene);

// Warns if no drive with `along: turns` turns (one straight drive among others is normal), of implausible recorded
// drives, and of frames closer than the slowest sensor's revolution.
std::vector<std::string> driveWarnings(const Pipeline& pipeline);

// Warns of sensors whose files have no effects, if the pipeline uses those of the files of other sensors, and of values
// that effects assume because a sensor's file does not give them.
std::vector<std::string> sensorWarnings(const Plan& plan);

// Warns of sensors at least half of whose rays hit the ego vehicle. `blocked`: result of ShotSource::blockedShares().
std::vector<std::string> vehicleWarnings(const Pipeline& pipeline, const std::vector<double>& blocked);

}  // namespace scanmill
