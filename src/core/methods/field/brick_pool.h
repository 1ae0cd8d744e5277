#pragma once

// Stores the bricks near surfaces ("full bricks") of a moving field: fields at successive positions share a pool, so
// that their common bricks are stored once.

#include <cstdint>
#include <mutex>
#include <vector>

#include "base/raw_vector.h"
#include "methods/field/distance_field.h"

namespace scanmill {

// A brick and its lists of triangles have a fixed place in the pool. Moving a field appends the new bricks, and only
// these are uploaded to a device that has the earlier ones. If the pool is full, the field gets a new pool, to which
// the bricks that it still needs are copied. The arrays are never reallocated, so that threads may read bricks while
// others are appended.
struct BrickPool {
  // Reserves space for `most` bricks, and none for lists.
  explicit BrickPool(std::size_t most) {
    distance.resize(most * kBrickStride);
    word.resize(most * kBrickStride);
    firstList.assign(most + 1, 0);
  }
  std::size_t room() const { return firstList.size() - 1 - bricks; }

  // The arrays of DistanceField. The elements of the first `bricks` bricks are set.
  RawVector<std::uint16_t> distance;
  RawVector<std::uint32_t> word;
  RawVector<std::uint32_t> lists;
  std::vector<std::uint32_t> firstList;  // index in `lists` of each brick's first list; entry `bricks`: the end

  std::mutex appending;  // locked while bricks are appended
  std::size_t bricks = 0;
};

}  // namespace scanmill
