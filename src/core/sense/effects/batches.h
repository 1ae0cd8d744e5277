#pragma once

// Functions for batches of neighbouring rows of the table of returns: they compute the random numbers of the rows,
// equal to those of randomBlock(), and look up the values of the rows' beams and hits.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/random.h"
#include "scan/hits.h"
#include "sense/effects/elementary.h"
#include "sense/returns.h"
#include "sensors/shot.h"

namespace scanmill {

constexpr std::size_t kBatch = 128;  // number of rows of a batch; a batch fits into the first-level cache

template <class T>
using Batch = std::array<T, kBatch>;

// Calls body(first, count) for every batch of rows that has at least one return. `ranges`: ranges of all rows (m).
template <class Body>
void forBatches(std::span<const float> ranges, Body body) {
  for (std::size_t first = 0; first < ranges.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, ranges.size() - first);
    std::uint32_t hasReturn = 0;
    for (std::size_t i = 0; i < count; ++i) hasReturn |= ranges[first + i] < kMiss ? 1u : 0u;
    if (hasReturn != 0) body(first, count);
  }
}

struct RandomWords {
  Batch<std::uint32_t> a, b;
};

// Returns the random words of row `number` of a beam.
inline RandomBlock drawBlock(const Shot& shot, Purpose purpose, std::uint32_t beam, std::uint32_t number = 0) {
  return randomBlock({shot.seed, shot.scene, shot.randomFrame(), shot.sensor, beam, number, purpose});
}

// Calls visit(i, block) for each row first + i of a batch. `block`: the random words for the row's address. If there is
// one row per beam, also visits rows beyond the last one, so that the loop has a fixed length.
template <class Visit>
void drawBlocks(const Shot& shot, Purpose purpose, const Returns& returns, std::size_t first, const Visit& visit) {
  if (returns.onePerBeam()) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      visit(i, drawBlock(shot, purpose, static_cast<std::uint32_t>(first + i)));
    }
    return;
  }
  const std::size_t count = std::min(kBatch, returns.size() - first);
  for (std::size_t i = 0; i < count; ++i) {
    visit(i, drawBlock(shot, purpose, returns.beam(first + i), returns.number(first + i)));
  }
}

// Sets `words` to two random words for each row of the batch that begins at row `first`.
inline void drawWords(const Shot& shot, Purpose purpose, const Returns& returns, std::size_t first,
                      RandomWords& words) {
  drawBlocks(shot, purpose, returns, first, [&](std::size_t i, const RandomBlock& block) {
    words.a[i] = block[0];
    words.b[i] = block[1];
  });
}

// Returns a pointer to the values of rows first, first + 1, ...: into `values`, which has one entry per hit, if there
// is one row per beam; otherwise to `buffer`, with copies. Rows without a hit get `none`.
template <class T>
const T* valuesOfHits(const Returns& returns, const std::vector<T>& values, std::size_t first, Batch<T>& buffer,
                      T none = {}) {
  if (returns.onePerBeam()) return values.data() + first;
  const std::size_t count = std::min(kBatch, returns.size() - first);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t hit = returns.hit(first + i);
    buffer[i] = hit == kNoHit ? none : values[hit];
  }
  return buffer.data();
}

// Does the same as valuesOfHits() for `values` that have one entry per beam.
template <class T>
const T* valuesOfBeams(const Returns& returns, const std::vector<T>& values, std::size_t first, Batch<T>& buffer) {
  if (returns.onePerBeam()) return values.data() + first;
  const std::size_t count = std::min(kBatch, returns.size() - first);
  for (std::size_t i = 0; i < count; ++i) buffer[i] = values[returns.beam(first + i)];
  return buffer.data();
}

// Returns a range (m) with an error (m) added, but at least 1 mm (or the range, if that is less), so that no point is
// behind the sensor. A missing return (kMiss) stays missing.
inline float rangeWithError(float range, double error) {
  constexpr double kLeastRange = 0.001;  // m
  const double exact = range;
  const double nearest = exact < kLeastRange ? exact : kLeastRange;
  const double reported = exact + error;
  return range < kMiss ? static_cast<float>(reported > nearest ? reported : nearest) : kMiss;
}

// Two independent standard normal numbers, computed from two words: Box and Muller, "A note on the generation of random
// normal deviates", 1958. Absolute values are at most sqrt(-2 log(2^-33)) = 6.76.
struct NormalPair {
  double first, second;
};

inline NormalPair normalPair(std::uint32_t a, std::uint32_t b) {
  const double radius = std::sqrt(-2 * naturalLog((toDouble(a) + 0.5) * 0x1p-32));
  const SinCos angle = sinCosRandom(b);
  return {radius * angle.cos, radius * angle.sin};
}

}  // namespace scanmill
