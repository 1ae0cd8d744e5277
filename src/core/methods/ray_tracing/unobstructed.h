#pragma once

// Counts the beams that would hit a thing (an object instance) if nothing occluded it. True visibility is measured
// against this count.

#include <cstdint>
#include <memory>

#include "methods/world/worlds.h"
#include "scene/thing_boxes.h"
#include "sensors/beam_grid.h"
#include "sensors/shot.h"

namespace scanmill {

// Embree's occlusion filter for the queries of Unobstructed, which accepts only hits on the thing.
void thingFilter(const RTCFilterFunctionNArguments* arguments);

// Traces rays from where they enter a thing's box to where they leave it, and ignores everything but the thing. So only
// beams that cross the box take time. Alpha cut-outs and motion are modelled as in ray tracing.
class Unobstructed {
 public:
  // Both must outlive this object. `worlds` are of the same scene as `boxes`, and are built with thingFilter() for
  // occlusions.
  Unobstructed(const Worlds& worlds, const ThingBoxes& boxes) : worlds_(worlds), boxes_(boxes) {}

  struct View {
    std::uint32_t beams = 0;  // beams that would hit the thing within the sensor's range
    // Index of the beam in the middle of these by firing time; if there are none, of a beam that fires when the sensor
    // looks towards the thing.
    std::uint32_t middle = 0;
  };
  // Returns the view of a thing in a shot, traced with one ray along the axis of each beam. `grid` is that of the
  // shot's beams. Safe to call from several threads.
  View of(std::size_t thing, const Shot& shot, const BeamGrid& grid) const;

 private:
  const Worlds& worlds_;
  const ThingBoxes& boxes_;
};

}  // namespace scanmill
