#pragma once

// Compares the hits of one method with those of another, beam by beam.

#include <cstdint>
#include <span>
#include <vector>

#include "evaluate/spread.h"
#include "methods/method.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

// Throws Error if beams fire several rays: methods are compared beam by beam.
void requireOneRay(const Hits& hits);

struct HitErrors {
  std::uint64_t beams = 0;
  std::uint64_t bothHit = 0;
  std::uint64_t falseNegatives = 0;  // only the reference hits
  std::uint64_t falsePositives = 0;  // only the tested method hits
  std::uint64_t sameLabel = 0;       // beams of bothHit with the same class and instance
  std::uint64_t interior = 0;        // beams away from edges
  std::uint64_t interiorAgree = 0;   // interior beams that both miss, or that both hit with the same label
  Spread range;                      // |tested - reference| (m) of the beams of bothHit
  Spread rangeSameSurface;           // range errors of beams with the same instance and class
  Spread rangeInterior;              // range errors of interior beams
};

// Compares hits that have the channels Instance and Semantic. `edges` holds 1 for beams near an edge, as edgeBeams()
// returns it; if it is empty, all beams are interior. Throws Error if the sizes differ, or beams fire several rays.
HitErrors compareHits(const Hits& reference, const Hits& tested, std::span<const std::uint8_t> edges);

// Finds the beams near an edge. For each beam, eight further beams are traced at `angle` (rad) above, below, left,
// right and in the four corners between. The result is 1 if one of them hits another instance or class, if only one of
// the two beams hits, or if the ranges differ by more than a slope of the surface explains (a tenth of the range), and
// else 0.
std::vector<std::uint8_t> edgeBeams(const Method& method, const Shot& shot, double angle);

}  // namespace scanmill
