#pragma once

#include <gtest/gtest.h>

#include <bit>
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

// To the bit.
inline void expectSameHits(const Hits& a, const Hits& b) {
  EXPECT_EQ(a.rings, b.rings);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.channels, b.channels);
  EXPECT_EQ(bitsOf(a.range), bitsOf(b.range));
  EXPECT_EQ(bitsOf(a.normal), bitsOf(b.normal));
  EXPECT_EQ(a.instance, b.instance);
  EXPECT_EQ(a.semantic, b.semantic);
  EXPECT_EQ(a.material, b.material);
  EXPECT_EQ(a.primitive, b.primitive);
  EXPECT_EQ(bitsOf(a.reflectance), bitsOf(b.reflectance));
  EXPECT_EQ(bitsOf(a.incidence), bitsOf(b.incidence));
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
