#pragma once

// Details that make a facade more than a plane: rooms behind the glass, courses and corner stones, bays, porches, ivy,
// awnings, a garage. All in the house's frame (see House).

#include <cstdint>

#include "models/models.h"

namespace scanmill::models {

// Dimensions of a house (m) and the surfaces of its parts.
struct HouseMeasures {
  double base = 0.3;    // height of the ground floor above the ground
  double storey = 2.9;  // from floor to floor
  double wallTop = 6;
  double sill = 0.8;  // lower edge of windows above the floor of their storey
  double windowWidth = 1.2, windowHeight = 1.4;
  double reveal = 0.14;      // how far windows are set back
  double foundation = -0.4;  // where walls begin
  SurfaceIndex wall = 0, trim = 0, tile = 0, metal = 0, wood = 0, glass = 0;
};

void addHouseDetails(Shape& shape, std::uint64_t seed, const House& house, const HouseMeasures& measures);

}  // namespace scanmill::models
