#pragma once

// Counts the beams that would hit a thing (an object instance) if nothing occluded the thing. The visible fraction of a
// thing is measured relative to this count.

#include <cstdint>

#include "methods/world/worlds.h"
#include "scene/thing_boxes.h"
#include "sensors/beam_grid.h"
#include "sensors/shot.h"

namespace scanmill {

// Embree's occlusion filter for the class Unobstructed: accepts only hits on the thing whose visibility is computed.
void thingFilter(const RTCFilterFunctionNArguments* arguments);

// Traces rays only inside of a thing's box, and ignores all surfaces except the thing's. Beams that do not cross the
// box therefore take no time. Alpha cut-outs and motion are modelled as in ray tracing.
class Unobstructed {
 public:
  // `worlds` (with thingFilter() for occlusions) and `boxes` must be of one scene, and must outlive this object.
  Unobstructed(const Worlds& worlds, const ThingBoxes& boxes) : worlds_(worlds), boxes_(boxes) {}

  struct View {
    std::uint32_t beams = 0;  // number of beams that would hit the thing within the sensor's range
    // Index of a beam whose firing time counts as the time at which the sensor sees the thing: the median of the
    // `beams` beams by firing time. If `beams` is 0, the beam of the middle ring nearest to the thing's direction.
    std::uint32_t middle = 0;
  };
  // Returns the view of a thing (an index into ThingBoxes::things()) in a shot, traced with one ray along the axis of
  // each beam. `grid`: the grid of the shot's beams. Safe to call from several threads.
  View viewOf(std::size_t thing, const Shot& shot, const BeamGrid& grid) const;

 private:
  const Worlds& worlds_;
  const ThingBoxes& boxes_;
};

}  // namespace scanmill
