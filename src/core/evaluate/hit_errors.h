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

struct HitErrors {
  std::uint64_t beams = 0;
  std::uint64_t bothHit = 0;
  std::uint64_t lost = 0;       // only the reference hits
  std::uint64_t spurious = 0;   // only the tested hits
  std::uint64_t sameLabel = 0;  // class and instance, of those that both hit
  // Beams away from edges: both hit or miss alike, with the same label.
  std::uint64_t interior = 0;
  std::uint64_t interiorAgree = 0;
  Spread range;             // |tested - reference| (m) where both hit
  Spread rangeSameSurface;  // where both hit the same instance and class
  Spread rangeInterior;     // of the interior beams that both hit
};

// Both need the channels Instance and Semantic. `edges`: 1 where a beam lies near an edge (see edgeBeams), or empty:
// all are interior. Throws Error where the sizes differ.
HitErrors compareHits(const Hits& reference, const Hits& tested, std::span<const std::uint8_t> edges);

// 1 for each beam beside which, at `angle` (rad) up, down, left, right and between, another instance, class or nothing
// is met, or the range steps by more than the surface's slope explains (a tenth of the range).
std::vector<std::uint8_t> edgeBeams(const Method& method, const Shot& shot, double angle);

}  // namespace scanmill
