#pragma once

// Counts the beams that would hit a thing (an object instance) if nothing occluded the thing. The visible fraction of a
// thing is measured relative to this count.

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "methods/world/resolve.h"
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
  // A placed block of a thing's triangles, and the thing's number in it (HitSurface::instance).
  using NumberedBlock = std::pair<const PlacedBlock*, std::uint32_t>;
  // The views of all things in a shot share these values.
  struct Sight {
    const Shot& shot;
    const BeamGrid& grid;  // of the shot's beams
    std::shared_ptr<const World> world;
    ShotFrame frame;
    const Hits* met;            // hits of the shot in the same worlds, with the instances; null: unknown
    std::uint32_t raysPerBeam;  // of `met`; the first ray of each beam is its axis
    // The blocks of each thing, by its instance id; empty if the world has baked triangles, whose things have no block.
    std::unordered_map<std::uint32_t, std::vector<NumberedBlock>> blocks;
  };
  // `met`: see Sight. A beam that met the thing sees it, and one that met something behind the thing's box does not;
  // only the others are traced. All arguments must outlive the result.
  Sight sightOf(const Shot& shot, const BeamGrid& grid, const Hits* met = nullptr, std::uint32_t raysPerBeam = 1) const;
  // Returns the view of a thing (an index into ThingBoxes::things()), traced with one ray along the axis of each beam.
  // Safe to call from several threads.
  View viewOf(std::size_t thing, const Sight& sight) const;

 private:
  const Worlds& worlds_;
  const ThingBoxes& boxes_;
};

}  // namespace scanmill
