#pragma once

#include <span>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// The distances between the points of a true and of a tested cloud. Points that are not finite are ignored.
struct CloudDistances {
  // Distance (m) of each true point to the tested cloud; NaN if the point is not finite or the tested cloud is empty.
  std::vector<float> to;
  // Distance (m) of each tested point to the true cloud; NaN if the point is not finite or the true cloud is empty.
  std::vector<float> from;
};
CloudDistances cloudDistances(std::span<const Vec3f> truth, std::span<const Vec3f> tested);

}  // namespace scanmill
