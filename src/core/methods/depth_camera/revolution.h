#pragma once

// Inside of the depth camera: a revolution of a sensor, cut into steps that are drawn from one pose each.

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

// Cuts a revolution into steps of about equally many poses, each drawn from its middle one. There are `renders` of
// them, but at most one per pose. For `renders` 0 there is one per pose where there are at most 64 poses, else one for
// every 5 cm or degree that the sensor moves during the revolution.
std::vector<RevolutionStep> stepsOf(const Shot& shot, std::uint32_t renders);

// The beams of columns `first` to `end`, relative to the rig, ring by ring.
RigBeams rigBeams(const Shot& shot, std::uint32_t first, std::uint32_t end, const Pose& worldFromRig);

// Directions in which the rig's cameras must look to see all that these beams may meet: those of the beams and, where
// beams start beside the rig's origin, those of the nearest points that they may meet.
std::vector<Vec3d> viewDirections(const RigBeams& beams);

}  // namespace scanmill
