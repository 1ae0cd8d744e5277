#pragma once

// Regular grids for quantised floats. What a reader computes from a grid's indices in float32 is within a stated bound
// of the original value.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scanmill {

// The component c of a grid point is low[c] + index * step, which a reader computes as float(float(index) * step) +
// low[c].
struct Grid {
  std::vector<float> low;
  float step = 1;
};

// Chooses a grid for values between `low` and `high`, which have one entry per component. No value is moved by more
// than `bound`, a Euclidean distance over the components, with the rounding in the reader included. A side has at most
// 2^30 points. Where float32 has enough bits, the grid's points are exact and all of the bound goes into the step.
// Throws an InputError that names `what` and says which bound is possible.
Grid chooseGrid(std::span<const float> low, std::span<const float> high, double bound, const std::string& what);

// At most how many bits the largest index has on such a grid for values between -reach and reach.
int mostIndexBits(double reach, std::size_t components, double bound);

// Writes the index of the nearest grid point for each value; the components of a point follow each other. `indices` has
// room for as many as there are values.
void quantise(std::span<const float> values, const Grid& grid, std::int32_t* indices);

}  // namespace scanmill
