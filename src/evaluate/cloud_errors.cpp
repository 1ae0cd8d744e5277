#include "evaluate/cloud_errors.h"

#include <algorithm>

#include "evaluate/cloud_distance.h"

namespace scanmill {

namespace {

std::size_t finiteCount(std::span<const Vec3f> points) {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [](const Vec3f& p) { return isFinite(p); }));
}

void append(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

void CloudErrorSum::add(std::span<const Vec3f> truth, std::span<const Vec3f> tested) {
  const std::size_t there = finiteCount(truth);
  const std::size_t here = finiteCount(tested);
  if (there == 0 || here == 0) {
    unmatched_ += there + here;
    return;
  }
  append(to_, distancesToNearest(truth, tested));
  append(from_, distancesToNearest(tested, truth));
}

CloudErrors CloudErrorSum::finish() const {
  CloudErrors errors;
  errors.to = spreadOf(to_);
  errors.from = spreadOf(from_);
  errors.hausdorff = std::max(errors.to.max, errors.from.max);
  errors.unmatched = unmatched_;
  return errors;
}

CloudErrors cloudErrors(std::span<const Vec3f> truth, std::span<const Vec3f> tested) {
  CloudErrorSum sum;
  sum.add(truth, tested);
  return sum.finish();
}

}  // namespace scanmill
