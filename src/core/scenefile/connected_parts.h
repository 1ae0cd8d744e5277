#pragma once

// Finds groups of connected triangles.

#include <cstdint>
#include <vector>

#include "assets/asset.h"
#include "base/vec.h"

namespace scanmill {

struct ConnectedParts {
  std::vector<std::vector<std::uint32_t>> of;  // number of the connected part, by asset part and triangle
  std::vector<Box> boxes;                      // m, by number of the connected part
};

// Returns the connected parts. Triangles are connected if they have corners at the same place, even in different asset
// parts. Connected parts are numbered from 0 in the order of their first triangles.
ConnectedParts connect(const std::vector<const AssetPart*>& parts);

// Groups connected parts into things by their boxes. Returns, by connected part, the number of its thing, from 0. A
// part belongs to a larger one if their boxes are at most 5 cm apart and either a quarter of its footprint (as seen
// from above) lies within the larger box, as with the wheels of a car and the tiers of a tree, or its diagonal is less
// than 0.15 of the larger one's, as with mirrors.
std::vector<std::uint32_t> thingsOf(const std::vector<Box>& connected);

}  // namespace scanmill
