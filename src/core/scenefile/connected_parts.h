#pragma once

// Triangles that hang together.

#include <cstdint>
#include <vector>

#include "assets/asset.h"
#include "base/vec.h"

namespace scanmill {

struct ConnectedParts {
  std::vector<std::vector<std::uint32_t>> of;  // by asset part and triangle: the number of what it is connected with
  std::vector<Box> boxes;                      // m, by that number
};

// Triangles are connected where corners are at the same place, also those of different asset parts. Numbers count from
// 0 in the order of the first triangles.
ConnectedParts connect(const std::vector<const AssetPart*>& parts);

// Numbers from 0 of things, by the numbers of connected parts. A part belongs to a larger one whose box is at most 5 cm
// from its own where a quarter of its footprint, as seen from above, lies within that box, as wheels do with a car and
// the tiers of a tree with each other; or where it is small beside it (less than 0.15 of its diagonal), as mirrors are.
std::vector<std::uint32_t> thingsOf(const std::vector<Box>& connected);

}  // namespace scanmill
