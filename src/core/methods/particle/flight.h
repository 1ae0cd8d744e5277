#pragma once

// From beams to particles, and from where particles landed to hits.

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "methods/field/field.h"
#include "methods/march/march.h"
#include "methods/particle/options.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

// A shot, and the field that its particles fly through.
struct Flight {
  const Shot& shot;
  const World& world;
  const Field& field;
  const ShotFrame& frame;  // of the world's origin
  ParticleOptions::Refine refine;
  MarchOptions march;
  Box box;     // m, relative to the world's origin: where the field is
  bool whole;  // nothing of the scene lies outside of the box
};

// What became of beams that is neither hit nor miss, or no trustworthy hit.
struct FlightCounts {
  std::uint64_t exhausted = 0;  // out of steps
  std::uint64_t left = 0;       // out of the field, which does not hold all of the scene
  std::uint64_t touching = 0;   // started so near to a surface that they were at rest at once
  FlightCounts& operator+=(const FlightCounts& o);
};

// Fills kPacket particles for each tile, from number `first` on; those that a tile does not have miss.
void launch(const Flight& flight, std::span<const Tile> tiles, Particles& particles, std::size_t first);

// Of the same particles: lets them through what is transparent (fields with lists), then fills the channels that `hits`
// has, and adds the beams that are neither hits nor misses to `unresolved`.
FlightCounts land(const Flight& flight, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                  Particles& particles, Landings& landings, std::size_t first, Hits& hits,
                  std::vector<std::uint32_t>& unresolved);

}  // namespace scanmill
