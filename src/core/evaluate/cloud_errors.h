#pragma once

// How far two clouds lie apart, seen from both.

#include <cstddef>
#include <span>
#include <vector>

#include "base/vec.h"
#include "evaluate/spread.h"

namespace scanmill {

// All zero where both clouds are empty. Where one is: its own direction has no points, and `unmatched` counts those of
// the other, whose distances are unknown.
struct CloudErrors {
  Spread to;             // from each true point to the nearest tested one (m)
  Spread from;           // from each tested point to the nearest true one (m)
  double hausdorff = 0;  // the largest of either (m)
  std::size_t unmatched = 0;
};

// Of a pair of clouds.
struct CloudDistances {
  std::vector<float> to;      // m, by true point; NaN where it is not finite, or where no tested point is
  std::vector<float> from;    // m, by tested point, likewise
  std::size_t unmatched = 0;  // finite points of one cloud where the other has none
};
CloudDistances cloudDistances(std::span<const Vec3f> truth, std::span<const Vec3f> tested);

// Points that are not finite do not count.
CloudErrors cloudErrors(std::span<const Vec3f> truth, std::span<const Vec3f> tested);

// The same over several pairs of clouds: points look for neighbours in their own pair alone, then all distances count
// alike.
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
