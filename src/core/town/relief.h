#pragma once

// Smooth random fields over the ground, for its unevenness and for other properties that vary with position.

#include <cstdint>

namespace scanmill::town {

// The purpose of a random field. Each value is used in one place of the code. The town of a seed depends on the values:
// append new values, never renumber.
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

// Returns the value of a random field at (x, y): gradient noise (Perlin, "Improving noise", SIGGRAPH 2002) on a lattice
// of `size` metres, whose gradients follow from the address. Values are between -1 and 1, with mean 0 and a standard
// deviation of about 0.25, and are the same on every machine, since sums and products are in a fixed order.
double relief(const FieldAddress& address, double x, double y, double size);

}  // namespace scanmill::town
