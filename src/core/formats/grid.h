#pragma once

// Regular grids for quantised floats. The value that a reader computes in float32 from an index differs from the
// original value by at most a given bound.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scanmill {

// The component c of a grid point is low[c] + index * step. A reader computes it as float(float(index) * step) +
// low[c].
struct Grid {
  std::vector<float> low;
  float step = 1;
};

// Chooses a grid for values between `low` and `high`, which have one entry per component. Quantising moves no point by
// more than `bound`, a Euclidean distance over all components that includes the reader's rounding. Each side of the
// grid has at most 2^30 points. If float32 has enough bits, the grid's points are exact in float32 and the step is as
// large as the bound allows. If the bound is too small, throws an InputError that names `what` and the smallest
// possible bound.
Grid chooseGrid(std::span<const float> low, std::span<const float> high, double bound, const std::string& what);

// Returns an upper bound of the number of bits of an index on the grid that chooseGrid() chooses for values between
// -reach and reach.
int mostIndexBits(double reach, std::size_t components, double bound);

// Writes for each value the index of the nearest grid point; the components of a point follow each other. `indices`
// must have room for one index per value.
void quantise(std::span<const float> values, const Grid& grid, std::int32_t* indices);

}  // namespace scanmill
