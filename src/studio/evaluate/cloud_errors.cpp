#include "evaluate/cloud_errors.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "evaluate/cloud_distance.h"

namespace scanmill {

namespace {

std::size_t finiteCount(std::span<const Vec3f> points) {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [](const Vec3f& p) { return isFinite(p); }));
}

// Returns for each point of `from` the distance to the nearest point of `to`; NaN for points that are not finite. Float
// is exact enough, since the points are float32 too.
std::vector<float> distancesByPoint(std::span<const Vec3f> from, std::span<const Vec3f> to) {
  const std::vector<double> known = distancesToNearest(from, to);
  std::vector<float> distances(from.size(), std::numeric_limits<float>::quiet_NaN());
  auto next = known.begin();
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (isFinite(from[i])) distances[i] = static_cast<float>(*next++);
  }
  return distances;
}

void appendKnown(std::vector<float>& all, const std::vector<float>& more) {
  std::copy_if(more.begin(), more.end(), std::back_inserter(all), [](float d) { return !std::isnan(d); });
}

}  // namespace

CloudDistances cloudDistances(std::span<const Vec3f> truth, std::span<const Vec3f> tested) {
  const std::size_t there = finiteCount(truth);
  const std::size_t here = finiteCount(tested);
  if (there > 0 && here > 0) return {distancesByPoint(truth, tested), distancesByPoint(tested, truth), 0};
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  return {std::vector<float>(truth.size(), kUnknown), std::vector<float>(tested.size(), kUnknown), there + here};
}

void CloudErrorSum::add(const CloudDistances& distances) {
  appendKnown(to_, distances.to);
  appendKnown(from_, distances.from);
  unmatched_ += distances.unmatched;
}

CloudErrors CloudErrorSum::finish() const {
  CloudErrors errors;
  errors.to = spreadOf({to_.begin(), to_.end()});
  errors.from = spreadOf({from_.begin(), from_.end()});
  errors.hausdorff = std::max(errors.to.max, errors.from.max);
  errors.unmatched = unmatched_;
  return errors;
}

CloudErrors cloudErrors(std::span<const Vec3f> truth, std::span<const Vec3f> tested) {
  CloudErrorSum sum;
  sum.add(cloudDistances(truth, tested));
  return sum.finish();
}

}  // namespace scanmill
