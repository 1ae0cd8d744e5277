#pragma once

// Finds the surfaces of a scene that boxes meet on their way.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// The surfaces of one class of an object that a box meets.
struct BoxContact {
  const Instance* instance = nullptr;
  std::uint16_t semantic = 0;
  std::size_t step = 0;  // index of the first step in which a box meets the surfaces
  double along = 0;      // m along the x axis of the box, where it meets them first in this step
  Vec3d place;           // where they are met (m, world frame): in the middle across the box
};

// Returns what some boxes meet that move together, the first first. A step is straight: a box is extended by the motion
// between the step's two poses, and turned as halfway between them. `boxes`: m, in the frame of the poses, not flat
// along any axis. `counts`: true for triangles that may not be met, given their instance, surface and unit normal in
// the world frame. Objects are where they are at time 0.
std::vector<BoxContact> sweepBoxes(const Scene& scene, const std::vector<Box>& boxes,
                                   const std::vector<std::pair<Pose, Pose>>& steps,
                                   const std::function<bool(const Instance&, const Surface&, const Vec3d&)>& counts);

}  // namespace scanmill
