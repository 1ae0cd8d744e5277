#pragma once

// Unevenness of the ground, and which way of it: smooth random fields over the plane.

#include <cstdint>

namespace scanmill::town {

// A field of mean 0 that varies over about `size` metres: gradient noise (Perlin, "Improving noise", SIGGRAPH 2002) on
// a lattice whose gradients follow from the seed. Between -1 and 1, its standard deviation is about 0.25. Equal on
// every machine: sums and products in a fixed order.
double relief(std::uint64_t seed, double x, double y, double size);

}  // namespace scanmill::town
