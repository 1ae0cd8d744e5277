#pragma once

// Smooth random fields over the plane, for the unevenness of the ground and for other properties that vary with
// position.

#include <cstdint>

namespace scanmill::town {

// Returns a random field of mean 0 that varies over about `size` metres: gradient noise (Perlin, "Improving noise",
// SIGGRAPH 2002) on a lattice whose gradients follow from the seed. Values are between -1 and 1 with a standard
// deviation of about 0.25. They are the same on every machine, since sums and products are in a fixed order.
double relief(std::uint64_t seed, double x, double y, double size);

}  // namespace scanmill::town
