#pragma once

// A field that moves, on a device: its arrays are made of those of the field before, which are there, and of its new
// bricks, which alone are uploaded.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "methods/field/distance_field.h"

namespace scanmill {

constexpr std::uint32_t kMoveLanes = 32;          // invocations that copy a brick
constexpr std::uint32_t kNewBrick = 0x80000000u;  // of a brick that the field before has not

struct MovedBricks {
  // Per brick: its index in the field before, or kNewBrick + its number among the new ones; where its lists lie there
  // (of new ones: behind firstLists), where they are to lie, and how many entries they have.
  std::vector<std::array<std::uint32_t, 4>> bricks;
  // Distances, words and lists of the new bricks, one kind after the other.
  std::vector<std::uint32_t> fresh;
  std::uint32_t firstWords = 0;  // in `fresh`
  std::uint32_t firstLists = 0;
};

// `firstList` is that of the field that it was moved from.
MovedBricks movedBricks(const DistanceField& field, const std::vector<std::uint32_t>& firstList);

// The compute program that does it, kMoveLanes invocations a brick; see gpu/compute.h. Storage buffers: 0 distances, 1
// words, 2 lists of the field before, 3 MovedBricks::fresh, 4 its bricks, 5 to 7 the arrays of the new field.
// Parameters: firstWords and firstLists.
std::string moveShader();

}  // namespace scanmill
