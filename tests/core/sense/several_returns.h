#pragma once

// Hits of beams that fire several rays, as tests want them.

#include "tests/core/sense/world.h"

namespace scanmill {

// Beams whose number leaves a rest of 0 when it is divided by 3 meet nothing; of 1, one surface at the world's range;
// of 2, two surfaces, the second one 5 m behind the first, with half of the power each and the farther ray first.
inline World makeSeveralReturns(std::uint32_t rings, std::uint32_t columns, float range = 10) {
  World world = makeWorld(rings, columns, range);
  const Hits one = world.hits;
  Hits& hits = world.hits;
  hits = Hits{};
  hits.rings = rings;
  hits.columns = columns;
  hits.channels = one.channels;
  const auto addRay = [&](std::uint32_t beam, float rayRange, std::uint16_t label, float weight) {
    hits.beamOfRay.push_back(beam);
    hits.weightOfRay.push_back(weight);
    hits.range.push_back(rayRange);
    hits.normal.push_back({});
    hits.instance.push_back(rayRange < kMiss ? 100 + beam : 0);
    hits.semantic.push_back(label);
    hits.material.push_back(0);
    hits.primitive.push_back(0);
    hits.reflectance.push_back(rayRange < kMiss ? 1.0f : 0.0f);
    hits.incidence.push_back(rayRange < kMiss ? 1.0f : 0.0f);
  };
  for (std::uint32_t beam = 0; beam < rings * columns; ++beam) {
    if (beam % 3 == 0) addRay(beam, kMiss, 0, 1);
    if (beam % 3 == 1) addRay(beam, range, 1, 1);
    if (beam % 3 != 2) continue;
    addRay(beam, range + 5, 2, 0.5f);
    addRay(beam, range, 1, 0.5f);
  }
  return world;
}

}  // namespace scanmill
