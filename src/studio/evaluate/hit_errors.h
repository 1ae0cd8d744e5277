#pragma once

// Compares the hits of two methods, beam by beam.

#include <cstdint>
#include <span>
#include <vector>

#include "evaluate/spread.h"
#include "methods/method.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

// Throws Error if beams fire several rays, since methods are compared beam by beam.
void requireOneRay(const Hits& hits);

struct HitErrors {
  std::uint64_t beams = 0;
  std::uint64_t bothHit = 0;
  std::uint64_t falseNegatives = 0;  // beams that hit only with the reference method
  std::uint64_t falsePositives = 0;  // beams that hit only with the tested method
  std::uint64_t sameLabel = 0;       // beams of bothHit with the same class and instance
  std::uint64_t interior = 0;        // beams that are not near an edge
  // Interior beams that miss with both methods, or hit with the same class and instance.
  std::uint64_t interiorAgree = 0;
  Spread range;             // |tested - reference range| of the beams in bothHit (m)
  Spread rangeSameSurface;  // |tested - reference range| of beams in bothHit with the same instance and class (m)
  Spread rangeInterior;     // |tested - reference range| of interior beams in bothHit (m)
};

// Compares hits, which must have the channels Range, Instance and Semantic. `edges`: for each beam 1 if it is near an
// edge, as returned by edgeBeams(); if it is empty, all beams are interior. Throws Error if the sizes differ, or if
// beams fire several rays.
HitErrors compareHits(const Hits& reference, const Hits& tested, std::span<const std::uint8_t> edges);

// Returns for each beam 1 if it is near an edge, otherwise 0. For this, eight neighbouring beams are traced at `angle`
// (rad) above, below, left, right and diagonally. The beam is near an edge if a neighbour hits another instance or
// class, if only one of the two has a hit, or if their ranges differ by more than a tenth of the range, which is more
// than the slope of a surface explains.
std::vector<std::uint8_t> edgeBeams(const Method& method, const Shot& shot, double angle);

}  // namespace scanmill
