#pragma once

// Random numbers for batches of neighbouring beams: the same numbers as randomBlock() gives one by one.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/random.h"
#include "effects/elementary.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

constexpr std::size_t kBatch = 128;  // beams; the working set of a batch stays in the nearest cache

template <class T>
using Batch = std::array<T, kBatch>;

// Calls body(first, count) for every batch of beams that holds at least one return.
template <class Body>
void forBatches(std::span<const float> range, Body body) {
  for (std::size_t first = 0; first < range.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, range.size() - first);
    std::uint32_t returned = 0;
    for (std::size_t i = 0; i < count; ++i) returned |= range[first + i] < kMiss ? 1u : 0u;
    if (returned != 0) body(first, count);
  }
}

struct RandomWords {
  Batch<std::uint32_t> a;
  Batch<std::uint32_t> b;
};

// The first two words of each beam's block, for beams first, first + 1, ...
inline void drawWords(const Shot& shot, Purpose purpose, std::size_t first, RandomWords& words) {
  for (std::size_t i = 0; i < kBatch; ++i) {
    const RandomBlock block = randomBlock(
        {shot.seed, shot.scene, shot.frame, shot.sensor, static_cast<std::uint32_t>(first + i), 0, purpose});
    words.a[i] = block[0];
    words.b[i] = block[1];
  }
}

// Two independent standard normal numbers from two words: Box and Muller, "A note on the generation of random normal
// deviates", 1958. The largest is sqrt(-2 log(2^-33)) = 6.76.
struct NormalPair {
  double first;
  double second;
};

inline NormalPair normalPair(std::uint32_t a, std::uint32_t b) {
  const double radius = std::sqrt(-2 * naturalLog((toDouble(a) + 0.5) * 0x1p-32));
  const SinCos angle = sinCosRandom(b);
  return {radius * angle.cos, radius * angle.sin};
}

}  // namespace scanmill
