#pragma once

// Finds the surfaces of a scene that boxes touch on their way.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// The surfaces of one class of an object that a box touches.
struct BoxContact {
  const Instance* instance = nullptr;
  std::uint16_t semantic = 0;
  std::size_t step = 0;  // index of the first step in which a box touches the surfaces
  double along = 0;      // m from the step's middle in the direction of travel, where the box touches them first
  Vec3d position;        // m, world frame: contact point, across the box the middle of the touched part
};

// Sweeps all boxes together along the steps and returns the first contact with an obstacle; nothing if no box touches
// one. A step is straight: each box is extended by the motion between the step's two poses, and has the rotation
// halfway between these poses. A box travels along its x axis, forwards or backwards. `boxes`: m, in the vehicle's
// frame, not flat along any axis. `steps`: worldFromVehicle at the start and at the end of each step. `isObstacle`:
// true for triangles that may not be touched, given their instance, surface and unit normal in the world frame. All
// objects are at their positions at time 0.
std::optional<BoxContact> sweepBoxes(
    const Scene& scene, const std::vector<Box>& boxes, const std::vector<std::pair<Pose, Pose>>& steps,
    const std::function<bool(const Instance&, const Surface&, const Vec3d&)>& isObstacle);

}  // namespace scanmill
