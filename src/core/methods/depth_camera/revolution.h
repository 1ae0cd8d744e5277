#pragma once

// Internal to the depth camera: splits a revolution of a sensor into steps, each of which is rendered from one pose.

#include <cstdint>
#include <vector>

#include "methods/depth_camera/depth_camera.h"
#include "sensors/shot.h"

namespace scanmill {

// Splits a revolution into `renders` steps, still without images, of about equally many poses, but at most one step per
// pose. Each step is rendered from its middle pose. If `renders` is 0, there is one step per pose for up to 64 poses;
// for more poses, one step for every 5 cm or every degree of motion during the revolution, whichever gives more steps.
std::vector<PassStep> stepsOf(const Shot& shot, std::uint32_t renders);

// Returns the beams of the columns from `first` to before `end`, relative to the rig, ring by ring.
RigBeams rigBeams(const Shot& shot, std::uint32_t first, std::uint32_t end, const Pose& worldFromRig);

// Returns directions that the rig's cameras must cover to see everything that the beams can hit: the directions of the
// beams and, if beams do not start at the rig's origin, the directions of the nearest points that these beams can hit.
std::vector<Vec3d> viewDirections(const RigBeams& beams);

}  // namespace scanmill
