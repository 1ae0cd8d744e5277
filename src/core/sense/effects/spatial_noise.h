#pragma once

// Random fields in space: values that differ from place to place in the world, and are the same for all sensors and at
// all times.

#include <cstdint>
#include <vector>

#include "base/random.h"
#include "scan/hits.h"
#include "sense/effects/batches.h"
#include "sense/returns.h"
#include "sensors/shot.h"

namespace scanmill {

// The positions of a batch of rows in the world (m).
struct Places {
  Batch<double> x;
  Batch<double> y;
  Batch<double> z;
};

// Finds the noise-free positions of the hits of rows, along their beams. A mirror image is where the sensor believes it
// to be, not at the surface.
class PlacesOfHits {
 public:
  PlacesOfHits(const Hits& hits, const Shot& shot, const Returns& returns);
  // Finds the positions of rows first, first + 1, ...; rows that come from no hit or were removed get the origin.
  // `along`, unless null, gets the beams' directions (unit vectors in the world), 0 for such rows.
  void find(std::size_t first, Places& places, Places* along = nullptr) const;

 private:
  const Hits& hits_;
  const Shot& shot_;
  const Returns& returns_;
  std::vector<Mat3> rotation_;  // world from sensor, per step
};

// A Gaussian field with mean 0 and variance 1 at every place. It is lattice noise: each corner of a lattice of cubes
// has a random number of mean 0 and variance 1, which depends on the corner and on the field's seed, purpose and
// number. The value at a place is a weighted sum over the corners of its cube (weights of Perlin, "Improving noise",
// SIGGRAPH 2002), scaled so that the squares of the weights add up to 1. Fields of different number or purpose are
// independent, and so are the values at places that lie two cubes or more apart along an axis.
struct SpatialField {
  std::uint64_t seed = 0;
  Purpose purpose = Purpose::Test;
  std::uint32_t number = 0;  // below 4096
};

// Adds factor[i] * field(place[i] * cubes[i]) to values[i]. `cubes`: the number of cubes per metre, for each row.
void addField(const SpatialField& field, const Places& places, const Batch<double>& cubes, const Batch<double>& factor,
              Batch<double>& values);

}  // namespace scanmill
