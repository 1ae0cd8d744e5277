#pragma once

// Smooth random fields over the plane, for the unevenness of the ground and for other properties of a town.

#include <cstdint>

namespace scanmill::town {

// The purpose of a random field. Each value is used in one place of the code. The towns of a seed depend on the values:
// append new ones, never renumber.
// clang-format off
enum class Field : std::uint32_t {
  Hills = 1, Slopes, Knolls, Ruts, WornSpots, Swells, Bumps, Banks, Roughness, Grain, SnowHeaps, SnowLumps, Woods,
  Clearings, Grass, MainRoadBehind, MainRoadAhead, SideRoad, Count
};
// clang-format on

// The address of a random field. Two different addresses give independent fields.
struct FieldAddress {
  std::uint64_t seed = 0;
  Field field = Field::Hills;
  std::uint32_t number = 0;  // index among the fields of this kind
};

// Returns a random field of mean 0 that varies over about `size` metres: gradient noise (Perlin, "Improving noise",
// SIGGRAPH 2002) on a lattice whose gradients follow from the address. Values are between -1 and 1 with a standard
// deviation of about 0.25. They are the same on every machine, since sums and products are in a fixed order.
double relief(const FieldAddress& address, double x, double y, double size);

}  // namespace scanmill::town
