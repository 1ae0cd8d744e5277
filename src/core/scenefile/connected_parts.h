#pragma once

// Finds groups of connected triangles.

#include <cstdint>
#include <vector>

#include "assets/asset.h"
#include "base/vec.h"

namespace scanmill {

struct ConnectedParts {
  std::vector<std::vector<std::uint32_t>> numbers;  // by asset part and triangle: number of its connected part
  std::vector<Box> boxes;                           // bounds (m) of the connected parts, by number
};

// Returns the connected parts. Triangles are connected if they have corners at the same position, even in different
// asset parts. Connected parts are numbered from 0 in the order of their first triangles.
ConnectedParts connect(const std::vector<const AssetPart*>& parts);

// Groups connected parts into things by their bounds (m). Returns, for each connected part, the number of its thing,
// from 0 in the order of the connected parts.
// A part is grouped with a larger part if their boxes are at most 5 cm apart and one of two conditions is true: at
// least a quarter of the smaller box's footprint (as seen from above) lies within the larger one's, as with the wheels
// of a car and the tiers of a tree; or the smaller box's diagonal is less than 0.15 of the larger one's, as with
// mirrors of a car.
std::vector<std::uint32_t> groupIntoThings(const std::vector<Box>& boxes);

}  // namespace scanmill
