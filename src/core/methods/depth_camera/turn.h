#pragma once

// Inside of the depth camera: a turn of a sensor, cut into steps that are drawn from one pose each.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "methods/depth_camera/sample.h"
#include "sensors/shot.h"

namespace scanmill {

struct TurnStep {
  std::uint32_t firstColumn = 0;
  std::uint32_t endColumn = 0;
  Pose worldFromRig;
};

// Steps of about equally many poses, each drawn from its middle one; at most one per pose. `renders` 0: all poses where
// the turn has at most 64, else one for every 5 cm or degree that the sensor moves during the turn.
std::vector<TurnStep> stepsOf(const Shot& shot, std::uint32_t renders);

// The beams of columns `first` to `end`, relative to the rig, ring by ring.
RigBeams rigBeams(const Shot& shot, std::uint32_t first, std::uint32_t end, const Pose& worldFromRig);

// Where these beams may look from the rig's origin: their directions and, where they start elsewhere, those of the
// nearest points that they may meet.
std::vector<Vec3d> viewDirections(const RigBeams& beams);

}  // namespace scanmill
