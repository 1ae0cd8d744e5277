#pragma once

// How far two clouds lie apart, seen from each of them.

#include <cstddef>
#include <span>
#include <vector>

#include "base/vec.h"
#include "evaluate/spread.h"

namespace scanmill {

// Everything is zero where both clouds are empty. Where one of them is empty, the direction that starts from it has no
// distances, and `unmatched` counts the points of the other cloud, whose distances are unknown.
struct CloudErrors {
  Spread to;             // from each true point to the nearest tested one (m)
  Spread from;           // from each tested point to the nearest true one (m)
  double hausdorff = 0;  // the largest distance of both directions (m)
  std::size_t unmatched = 0;
};

// The distances within a pair of clouds.
struct CloudDistances {
  std::vector<float> to;      // m, per true point; NaN where the point is not finite, or where there is no tested point
  std::vector<float> from;    // m, per tested point; NaN likewise
  std::size_t unmatched = 0;  // finite points of one cloud where the other has none
};
CloudDistances cloudDistances(std::span<const Vec3f> truth, std::span<const Vec3f> tested);

// How far two clouds lie apart. Points that are not finite do not count.
CloudErrors cloudErrors(std::span<const Vec3f> truth, std::span<const Vec3f> tested);

// The same over several pairs of clouds. Points look for neighbours in their own pair alone; the distances of all pairs
// count alike.
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
