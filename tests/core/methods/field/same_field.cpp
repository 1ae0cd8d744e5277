#include "tests/core/methods/field/same_field.h"

#include <cstddef>

namespace scanmill {

namespace {

bool sameList(const DistanceField& a, std::uint32_t wordA, const DistanceField& b, std::uint32_t wordB) {
  for (;; ++wordA, ++wordB) {
    if (a.lists[wordA] != b.lists[wordB]) return false;
    if (a.lists[wordA] >= kLastOfList) return true;
  }
}

bool sameBrick(const DistanceField& a, std::uint32_t entryA, const DistanceField& b, std::uint32_t entryB) {
  const std::size_t firstA = std::size_t{entryA - kFullBrick} * kBrickStride;
  const std::size_t firstB = std::size_t{entryB - kFullBrick} * kBrickStride;
  if (!std::ranges::equal(a.distance.subspan(firstA, kBrickStride), b.distance.subspan(firstB, kBrickStride))) {
    return false;
  }
  for (std::size_t c = 0; c < kBrickStride; ++c) {
    const std::uint32_t wordA = a.triangleOrList[firstA + c];
    const std::uint32_t wordB = b.triangleOrList[firstB + c];
    const bool lists = a.shape.lists && wordA != kNoTriangle && wordB != kNoTriangle;
    if (lists ? !sameList(a, wordA, b, wordB) : wordA != wordB) return false;
  }
  return true;
}

}  // namespace

bool sameField(const DistanceField& a, const DistanceField& b) {
  if (!(a.shape == b.shape) || a.table.size() != b.table.size()) return false;
  for (std::size_t i = 0; i < a.table.size(); ++i) {
    const bool full = a.table[i] >= kFullBrick && b.table[i] >= kFullBrick;
    if (full ? !sameBrick(a, a.table[i], b, b.table[i]) : a.table[i] != b.table[i]) return false;
  }
  return true;
}

}  // namespace scanmill
