#pragma once

// Random fields in space: values that vary from point to point in the world, but are equal for all sensors and times.

#include <cstdint>
#include <vector>

#include "base/random.h"
#include "scan/hits.h"
#include "sense/effects/batches.h"
#include "sense/returns.h"
#include "sensors/shot.h"

namespace scanmill {

// A position (m, world) or a direction for each row of a batch.
struct Positions {
  Batch<double> x, y, z;

  Vec3d at(std::size_t row) const { return {x[row], y[row], z[row]}; }
  void set(std::size_t row, const Vec3d& p) { x[row] = p.x, y[row] = p.y, z[row] = p.z; }
};

// Computes the positions of the rows' hits from the exact ranges along the beams, without the errors of effects. A
// mirror image is placed where the sensor assumes it, not at the surface.
class PositionsOfHits {
 public:
  PositionsOfHits(const Hits& hits, const Shot& shot, const Returns& returns);
  // Computes the positions of rows first, first + 1, ... of a batch. `directions`, if not null, gets the directions of
  // the beams (unit vectors in the world frame). A row that was removed or has no hit gets zero for both.
  void compute(std::size_t first, Positions& positions, Positions* directions = nullptr) const;

 private:
  const Hits& hits_;
  const Shot& shot_;
  const Returns& returns_;
  std::vector<Mat3> rotation_;       // from sensor to world axes, for each step of the revolution
  std::vector<std::size_t> stepOf_;  // step of each column
};

// A nearly Gaussian field with mean 0 and variance 1 at every point. It is lattice noise: each corner of a lattice of
// cubes has a random number of mean 0 and variance 1, which depends on the corner and on the field's seed, purpose and
// number. The value at a point is a weighted sum over the corners of the point's cube (weights of Perlin, "Improving
// noise", SIGGRAPH 2002), scaled so that the squares of the weights add up to 1. Fields with different number or
// purpose are independent, and so are the values at points that are two cubes or more apart along an axis.
//
// Neighbouring points are often in the same cube: the numbers of recent cubes are kept in a table.
class SpatialField {
 public:
  // `number`: distinguishes fields of the same purpose; below 4096.
  SpatialField(std::uint64_t seed, Purpose purpose, std::uint32_t number);
  // Adds factor[i] * field(positions[i] * cubesPerMetre[i]) to values[i]. `cubesPerMetre[i]`: number of the lattice's
  // cubes per metre for row i of the batch.
  void add(const Positions& positions, const Batch<double>& cubesPerMetre, const Batch<double>& factor,
           Batch<double>& values);

 private:
  static constexpr std::uint32_t kEntries = 1024;
  // An entry of the table of cubes. A cube's indices determine the only entry that may hold it.
  struct Entry {
    std::uint32_t x, y, z;  // indices of the lower corner, modulo 2^32
    std::uint32_t row;      // index in numbers_
  };
  struct CubeIndices {  // indices of lower corners, modulo 2^32, by row of the batch
    Batch<std::uint32_t> x, y, z;
  };

  using CornerNumbers = std::array<Batch<double>, 8>;  // by corner (see numbers_) and row of the batch

  // Computes the numbers at the corners of `count` cubes, and stores them in numbers_ behind the rows of all entries.
  void computeCorners(const CubeIndices& cubes, std::size_t count);

  // Sets `numbers` to the numbers at the corners of each row's cube, and adds cubes that the table lacks.
  void lookUp(const CubeIndices& cubes, CornerNumbers& numbers);

  std::uint32_t tag_;                 // number and purpose of the field
  std::array<std::uint32_t, 2> key_;  // the seed
  std::vector<Entry> entries_;
  std::vector<std::array<double, 8>> numbers_;  // by corner; corner 1 is the next along x, 2 along y, 4 along z
};

}  // namespace scanmill
