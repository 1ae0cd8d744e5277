#pragma once

// Compares the hits of two methods, beam by beam, for tests and benchmarks.

#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "evaluate/measure.h"

namespace scanmill {

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
inline HitErrors compareHits(const Hits& reference, const Hits& tested, std::span<const std::uint8_t> edges) {
  if (reference.size() != tested.size() || (!edges.empty() && edges.size() != reference.size())) {
    throw Error("hits of different numbers of beams cannot be compared");
  }
  requireOneRay(reference);
  requireOneRay(tested);
  HitErrors e;
  e.beams = reference.size();
  std::vector<double> all;
  std::vector<double> same;
  std::vector<double> interior;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const bool inside = edges.empty() || edges[i] == 0;
    e.interior += inside ? 1 : 0;
    if (!reference.hit(i) || !tested.hit(i)) {
      e.falseNegatives += reference.hit(i) ? 1 : 0;
      e.falsePositives += tested.hit(i) ? 1 : 0;
      e.interiorAgree += inside && reference.hit(i) == tested.hit(i) ? 1 : 0;
      continue;
    }
    ++e.bothHit;
    const double error = std::abs(double{tested.range[i]} - double{reference.range[i]});
    const bool label = reference.semantic[i] == tested.semantic[i] && reference.instance[i] == tested.instance[i];
    all.push_back(error);
    if (label) same.push_back(error);
    if (inside) interior.push_back(error);
    e.sameLabel += label ? 1 : 0;
    e.interiorAgree += inside && label ? 1 : 0;
  }
  e.range = spreadOf(std::move(all));
  e.rangeSameSurface = spreadOf(std::move(same));
  e.rangeInterior = spreadOf(std::move(interior));
  return e;
}

}  // namespace scanmill
