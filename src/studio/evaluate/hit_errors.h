#pragma once

// How the hits of one method differ from those of another, beam by beam.

#include <cstdint>
#include <span>
#include <vector>

#include "evaluate/spread.h"
#include "methods/method.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

// Throws Error where beams fire several rays: methods are compared beam by beam.
void requireOneRay(const Hits& hits);

struct HitErrors {
  std::uint64_t beams = 0;
  std::uint64_t bothHit = 0;
  std::uint64_t falseNegatives = 0;  // only the reference hits
  std::uint64_t falsePositives = 0;  // only the tested method hits
  std::uint64_t sameLabel = 0;       // beams of bothHit with the same class and instance
  std::uint64_t interior = 0;        // beams away from edges
  std::uint64_t interiorAgree = 0;   // interior beams that both miss, or that both hit with the same label
  Spread range;                      // |tested - reference| (m) where both hit
  Spread rangeSameSurface;           // the same where both hit the same instance and class
  Spread rangeInterior;              // the same of the interior beams that both hit
};

// Compares hits that have the channels Instance and Semantic. `edges` holds 1 where a beam lies near an edge, as
// edgeBeams() gives it; where it is empty, all beams are interior. Throws Error where the sizes differ, or beams fire
// several rays.
HitErrors compareHits(const Hits& reference, const Hits& tested, std::span<const std::uint8_t> edges);

// Tells which beams lie near an edge. Beams beside each beam are traced, `angle` (rad) up, down, left, right and
// between these. The result is 1 where one of them meets another instance, another class or nothing, or where the range
// steps by more than the surface's slope explains (a tenth of the range), and else 0.
std::vector<std::uint8_t> edgeBeams(const Method& method, const Shot& shot, double angle);

}  // namespace scanmill
