#pragma once

// Random fields in space: values that vary from point to point in the world, and are the same for all sensors and at
// all times.

#include <cstdint>
#include <vector>

#include "base/random.h"
#include "scan/hits.h"
#include "sense/effects/batches.h"
#include "sense/returns.h"
#include "sensors/shot.h"

namespace scanmill {

// The world positions of a batch of rows (m).
struct Places {
  Batch<double> x;
  Batch<double> y;
  Batch<double> z;
};

// Computes the noise-free positions of rows' hits, along their beams. A mirror image is placed where the sensor assumes
// it, not at the surface.
class PlacesOfHits {
 public:
  PlacesOfHits(const Hits& hits, const Shot& shot, const Returns& returns);
  // Computes the positions of rows first, first + 1, ... `along`, if not null, gets the directions of the beams (unit
  // vectors in the world frame). A row that was removed or has no hit gets zero for both.
  void find(std::size_t first, Places& places, Places* along = nullptr) const;

 private:
  const Hits& hits_;
  const Shot& shot_;
  const Returns& returns_;
  std::vector<Mat3> rotation_;  // from sensor to world axes, for each step of the revolution
};

// A nearly Gaussian field with mean 0 and variance 1 at every point. It is lattice noise: each corner of a lattice of
// cubes has a random number of mean 0 and variance 1, which depends on the corner and on the field's seed, purpose and
// number. The value at a point is a weighted sum over the corners of the point's cube (weights of Perlin, "Improving
// noise", SIGGRAPH 2002), scaled so that the squares of the weights add up to 1. Fields with different number or
// purpose are independent, and so are the values at points that are two cubes or more apart along an axis.
struct SpatialField {
  std::uint64_t seed = 0;
  Purpose purpose = Purpose::Test;
  std::uint32_t number = 0;  // number of the field, below 4096
};

// Adds factor[i] * field(place[i] * cubes[i]) to values[i]. `cubes[i]`: number of the lattice's cubes per metre for row
// i of the batch.
void addField(const SpatialField& field, const Places& places, const Batch<double>& cubes, const Batch<double>& factor,
              Batch<double>& values);

}  // namespace scanmill
