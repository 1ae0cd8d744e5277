#pragma once

// Adds details to the plane facade of a house: rooms behind the glass, bands and corner stones, bays, porches, ivy,
// awnings, a garage. All coordinates are in the house's frame (see House).

#include <cstdint>

#include "models/models.h"

namespace scanmill::models {

// Dimensions of a house (m) and the surfaces of its parts.
struct HouseMeasures {
  double base = 0.3;    // height of the ground floor above the ground
  double storey = 2.9;  // height from floor to floor
  double wallTop = 6;
  double sill = 0.8;  // height of the windows' lower edge above the floor of their storey
  double windowWidth = 1.2, windowHeight = 1.4;
  double foundation = -0.4;  // height where walls begin
  SurfaceIndex wall = 0, trim = 0, tile = 0, metal = 0, wood = 0, glass = 0;
};

void addHouseDetails(Shape& shape, std::uint64_t seed, const House& house, const HouseMeasures& measures);

}  // namespace scanmill::models
