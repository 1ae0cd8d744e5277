#pragma once

// What a sensor would see of a thing if nothing stood before it: what true visibility is measured against.

#include <cstdint>
#include <memory>

#include "methods/world/worlds.h"
#include "scene/thing_boxes.h"
#include "sensors/beam_grid.h"
#include "sensors/shot.h"

namespace scanmill {

// Embree's filter of the occlusions that it asks for.
void thingFilter(const RTCFilterFunctionNArguments* arguments);

// Rays are traced from where they enter a thing's box to where they leave it, and meet nothing but the thing: only
// beams that cross the box cost anything. Cut-outs by alpha count as in ray tracing, motion too.
class Unobstructed {
 public:
  // All must outlive it. `worlds`: of the scene that `boxes` are of, with thingFilter() for occlusions.
  Unobstructed(const Worlds& worlds, const ThingBoxes& boxes) : worlds_(worlds), boxes_(boxes) {}

  struct View {
    std::uint32_t beams = 0;  // that would meet the thing within the sensor's range
    // Index of the one that fires in the middle of them; where there is none, of one that fires when the sensor looks
    // into the direction in which the thing lies.
    std::uint32_t middle = 0;
  };
  // Of a thing in a shot, by one ray along the axis of each beam. `grid`: of the shot's beams. Safe to call from
  // several threads.
  View of(std::size_t thing, const Shot& shot, const BeamGrid& grid) const;

 private:
  const Worlds& worlds_;
  const ThingBoxes& boxes_;
};

}  // namespace scanmill
