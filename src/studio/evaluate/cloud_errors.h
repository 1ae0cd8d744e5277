#pragma once

// Measures the distances between two point clouds, in both directions.

#include <cstddef>
#include <span>
#include <vector>

#include "base/vec.h"
#include "evaluate/spread.h"

namespace scanmill {

// Statistics of the distances between two point clouds. If both clouds are empty, all values are zero. If only one
// cloud is empty, there are no distances, and `unmatched` is the number of points in the other cloud.
struct CloudErrors {
  Spread to;             // distances from each true point to the nearest tested point (m)
  Spread from;           // distances from each tested point to the nearest true point (m)
  double hausdorff = 0;  // maximum of all distances in both directions (m)
  std::size_t unmatched = 0;
};

// The distances between a true and a tested cloud. Points that are not finite are ignored.
struct CloudDistances {
  // Distance (m) of each true point to the tested cloud; NaN if the point is not finite or the tested cloud is empty.
  std::vector<float> to;
  // Distance (m) of each tested point to the true cloud; NaN if the point is not finite or the true cloud is empty.
  std::vector<float> from;
  std::size_t unmatched = 0;  // number of finite points in one cloud if the other cloud has none; otherwise 0
};
CloudDistances cloudDistances(std::span<const Vec3f> truth, std::span<const Vec3f> tested);

// Accumulates the distances of several pairs of clouds, all with the same weight. The nearest point is searched only
// within the same pair.
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
