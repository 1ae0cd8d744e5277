#pragma once

// The full bricks of a field and of the earlier fields from which it moved: bricks that several of them share are
// stored once.

#include <cstdint>
#include <mutex>
#include <vector>

#include "base/raw_vector.h"
#include "methods/field/distance_field.h"

namespace scanmill {

// A brick and its lists of triangles keep their place in the pool: moving a field appends the new bricks, and devices
// that hold the earlier ones are given only the new ones. If no room is left, the field gets a pool of its own, to
// which the bricks that it takes over are copied. The arrays never grow, so that threads may read bricks while others
// are appended.
struct BrickPool {
  // Makes room for `most` bricks, and none for lists yet.
  explicit BrickPool(std::size_t most) {
    distance.resize(most * kBrickStride);
    word.resize(most * kBrickStride);
    firstList.assign(most + 1, 0);
  }
  std::size_t room() const { return firstList.size() - 1 - bricks; }

  // The arrays of DistanceField, filled for the first `bricks` bricks.
  RawVector<std::uint16_t> distance;
  RawVector<std::uint32_t> word;
  RawVector<std::uint32_t> lists;
  std::vector<std::uint32_t> firstList;  // per brick: where its lists begin; one more for the end

  std::mutex appending;  // locked while bricks are appended
  std::size_t bricks = 0;
};

}  // namespace scanmill
