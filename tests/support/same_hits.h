#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <concepts>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "scan/hits.h"

namespace scanmill {

inline std::vector<std::uint32_t> bitsOf(const std::vector<float>& values) {
  std::vector<std::uint32_t> bits;
  for (const float value : values) bits.push_back(std::bit_cast<std::uint32_t>(value));
  return bits;
}

inline std::vector<std::uint32_t> bitsOf(const std::vector<Vec3f>& values) {
  std::vector<float> numbers;
  for (const Vec3f& value : values) numbers.insert(numbers.end(), {value.x, value.y, value.z});
  return bitsOf(numbers);
}

template <std::integral T>
const std::vector<T>& bitsOf(const std::vector<T>& values) {
  return values;
}

// To the bit.
inline void expectSameHits(const Hits& a, const Hits& b) {
  EXPECT_EQ(a.rings, b.rings);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.channels, b.channels);
  forEachChannel(
      [&](const ChannelRow& row, auto member) { EXPECT_EQ(bitsOf(a.*member), bitsOf(b.*member)) << row.name; });
  EXPECT_EQ(bitsOf(a.roughness), bitsOf(b.roughness));
  EXPECT_EQ(bitsOf(a.metallic), bitsOf(b.metallic));
  EXPECT_EQ(bitsOf(a.retroreflectance), bitsOf(b.retroreflectance));
  EXPECT_EQ(a.unresolved, b.unresolved);
}

// Expects trace() to return the same hits on one, two and eight threads.
template <class Trace>
void expectSameOnAnyThreads(const Trace& trace) {
  std::vector<Hits> results;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    results.push_back(trace());
  }
  expectSameHits(results[1], results[0]);
  expectSameHits(results[2], results[0]);
}

}  // namespace scanmill
