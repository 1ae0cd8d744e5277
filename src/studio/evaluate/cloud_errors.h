#pragma once

// Measures the distances between two clouds, in both directions.

#include <cstddef>
#include <span>
#include <vector>

#include "base/vec.h"
#include "evaluate/spread.h"

namespace scanmill {

// If both clouds are empty, all values are zero. If one cloud is empty, there are no distances in either direction, and
// `unmatched` counts the points of the other cloud, whose distances are unknown.
struct CloudErrors {
  Spread to;             // from each true point to the nearest tested one (m)
  Spread from;           // from each tested point to the nearest true one (m)
  double hausdorff = 0;  // the largest distance of both directions (m)
  std::size_t unmatched = 0;
};

// The distances within a pair of clouds.
struct CloudDistances {
  std::vector<float> to;      // m, per true point; NaN if the point is not finite, or if there is no tested point
  std::vector<float> from;    // m, per tested point; NaN likewise
  std::size_t unmatched = 0;  // finite points of one cloud if the other cloud has none
};
CloudDistances cloudDistances(std::span<const Vec3f> truth, std::span<const Vec3f> tested);

// Returns the distances between two clouds. Points that are not finite do not count.
CloudErrors cloudErrors(std::span<const Vec3f> truth, std::span<const Vec3f> tested);

// Adds up the distances of several pairs of clouds, all with the same weight. The nearest point is searched only within
// the same pair.
class CloudErrorSum {
 public:
  void add(const CloudDistances& distances);
  CloudErrors finish() const;

 private:
  std::vector<float> to_;
  std::vector<float> from_;
  std::size_t unmatched_ = 0;
};

}  // namespace scanmill
