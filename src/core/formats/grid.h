#pragma once

// Regular grids for quantised floats, whose points a reader in float32 finds again within a bound.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scanmill {

// Points low[c] + index * step, as a reader computes them: float(float(index) * step) + low[c].
struct Grid {
  std::vector<float> low;
  float step = 1;
};

// A grid for values between low and high, per component, that moves none by more than `bound` (Euclidean over the
// components), rounding in the reader included; at most 2^30 points a side. Where the numbers have enough bits, the
// grid's points are exact in float32 and all of the bound goes into the step. Throws InputError that names `what` and
// says which bound is possible.
Grid chooseGrid(std::span<const float> low, std::span<const float> high, double bound, const std::string& what);

// Bits of the largest index on such a grid for values between -reach and reach, at most.
int mostIndexBits(double reach, std::size_t components, double bound);

// Indices of the nearest grid points, as many as values, whose number is a multiple of the grid's components.
void quantise(std::span<const float> values, const Grid& grid, std::int32_t* indices);

}  // namespace scanmill
