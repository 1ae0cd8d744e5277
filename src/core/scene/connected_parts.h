#pragma once

// Triangles that hang together.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "scene/assets/asset.h"

namespace scanmill {

struct ConnectedParts {
  std::vector<std::vector<std::uint32_t>> of;  // by asset part and triangle: the number of what it is connected with
  std::vector<Box> boxes;                      // m, by that number
};

// Triangles are connected where corners are at the same place, also those of different asset parts. Numbers count from
// 0 in the order of the first triangles.
ConnectedParts connect(const std::vector<const AssetPart*>& parts);

// Numbers from 0 of things: a connected part whose middle lies in the box of a larger one belongs to that, as wheels do
// to a car. By the numbers of connected parts.
std::vector<std::uint32_t> thingsOf(const std::vector<Box>& connected);

}  // namespace scanmill
