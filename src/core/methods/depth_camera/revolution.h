#pragma once

// Internals of the depth camera: splits a revolution of a sensor into steps, each of which is rendered from one pose.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "methods/depth_camera/sample.h"
#include "sensors/shot.h"

namespace scanmill {

struct RevolutionStep {
  std::uint32_t firstColumn = 0;
  std::uint32_t endColumn = 0;
  Pose worldFromRig;
};

// Splits a revolution into `renders` steps of about equally many poses, at most one per pose. Each is rendered from its
// middle pose. If `renders` is 0, there is one step per pose for at most 64 poses, else one for every 5 cm or degree
// that the sensor moves during the revolution.
std::vector<RevolutionStep> stepsOf(const Shot& shot, std::uint32_t renders);

// Returns the beams of columns `first` to `end`, relative to the rig, ring by ring.
RigBeams rigBeams(const Shot& shot, std::uint32_t first, std::uint32_t end, const Pose& worldFromRig);

// Returns the directions in which the rig's cameras must look to see all that these beams may hit: those of the beams
// and, if beams do not start at the rig's origin, those of the nearest points that they may hit.
std::vector<Vec3d> viewDirections(const RigBeams& beams);

}  // namespace scanmill
