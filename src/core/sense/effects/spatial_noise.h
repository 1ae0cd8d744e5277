#pragma once

// Random fields in space: what varies from place to place in the world and stays there, whoever looks and when.

#include <cstdint>
#include <vector>

#include "base/random.h"
#include "scan/hits.h"
#include "sense/effects/batches.h"
#include "sense/returns.h"
#include "sensors/shot.h"

namespace scanmill {

// Of a batch of rows, in the world (m).
struct Places {
  Batch<double> x;
  Batch<double> y;
  Batch<double> z;
};

// Where the hits of rows are: noise-free, along their beams. A mirror image is where the sensor believes it.
class PlacesOfHits {
 public:
  PlacesOfHits(const Hits& hits, const Shot& shot, const Returns& returns);
  // Rows first, first + 1, ...; those that come from no hit, or are gone, lie in the origin. `along`, where wanted: the
  // beams' directions, unit vectors in the world; 0 of those rows.
  void find(std::size_t first, Places& places, Places* along = nullptr) const;

 private:
  const Hits& hits_;
  const Shot& shot_;
  const Returns& returns_;
  std::vector<Mat3> rotation_;  // world from sensor, per step
};

// A Gaussian field of mean 0 and variance 1 at every place: lattice noise (Perlin, "Improving noise", SIGGRAPH 2002,
// for its weights), with standard numbers at the corners of a lattice of cubes, drawn from a counter by seed, purpose
// and number of the field, and weighted so that the sum of the squares of the weights is 1. Fields of other numbers or
// purposes are independent, and so are places that lie two cubes or more apart along an axis.
struct SpatialField {
  std::uint64_t seed = 0;
  Purpose purpose = Purpose::Test;
  std::uint32_t number = 0;  // below 4096
};

// values[i] += factor[i] * field(place / cube). `cubes`: number of cubes a metre, of each row.
void addField(const SpatialField& field, const Places& places, const Batch<double>& cubes, const Batch<double>& factor,
              Batch<double>& values);

}  // namespace scanmill
