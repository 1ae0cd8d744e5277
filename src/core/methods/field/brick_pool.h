#pragma once

// Bricks near surfaces, of a field and of those that moved out of it: what two of them share is there once.

#include <cstdint>
#include <mutex>
#include <vector>

#include "base/raw_vector.h"
#include "methods/field/distance_field.h"

namespace scanmill {

// A brick keeps its place, and so does its list of triangles: moving a field appends the new bricks, and devices that
// have the others are given these alone. Where there is no more room, a field gets a pool of its own, with the bricks
// that it takes over in front. The arrays never grow, so that some read bricks while others are appended.
struct BrickPool {
  // Room for so many bricks, and for no lists yet.
  explicit BrickPool(std::size_t most) {
    distance.resize(most * kBrickStride);
    word.resize(most * kBrickStride);
    firstList.assign(most + 1, 0);
  }
  std::size_t room() const { return firstList.size() - 1 - bricks; }

  // As DistanceField has them; those of the first `bricks` bricks are there.
  RawVector<std::uint16_t> distance;
  RawVector<std::uint32_t> word;
  RawVector<std::uint32_t> lists;
  std::vector<std::uint32_t> firstList;  // per brick, and of the next one: where its lists begin

  std::mutex appending;  // held by who appends
  std::size_t bricks = 0;
};

}  // namespace scanmill
