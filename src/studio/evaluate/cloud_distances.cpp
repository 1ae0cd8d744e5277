#include <cmath>
#include <limits>
#include <nanoflann.hpp>

#include "base/parallel.h"
#include "evaluate/measure.h"

namespace scanmill {

namespace {

constexpr float kNoDistance = std::numeric_limits<float>::quiet_NaN();

struct Cloud {
  std::vector<Vec3f> points;  // finite points of the cloud (m)

  // The functions that nanoflann calls.
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return axis == 0 ? points[i].x : axis == 1 ? points[i].y : points[i].z;
  }
  template <class Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud, 3>;

Cloud finitePoints(std::span<const Vec3f> points) {
  Cloud cloud;
  cloud.points.reserve(points.size());
  for (const Vec3f& p : points) {
    if (isFinite(p)) cloud.points.push_back(p);
  }
  return cloud;
}

// Returns for each point of `from` the distance to the nearest finite point of `points`; NaN for points that are not
// finite, and if there is no finite point. Float is exact enough, since the points are float32 too.
std::vector<float> distancesByPoint(std::span<const Vec3f> from, std::span<const Vec3f> points) {
  std::vector<float> distances(from.size(), kNoDistance);
  const Cloud to = finitePoints(points);
  if (to.points.empty()) return distances;
  const Tree tree(3, to);
  parallelFor(from.size(), 1024, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (!isFinite(from[i])) continue;
      std::uint32_t index = 0;
      float square = 0;
      tree.knnSearch(&from[i].x, 1, &index, &square);
      distances[i] = static_cast<float>(std::sqrt(double{square}));
    }
  });
  return distances;
}

}  // namespace

CloudDistances cloudDistances(std::span<const Vec3f> truth, std::span<const Vec3f> tested) {
  return {distancesByPoint(truth, tested), distancesByPoint(tested, truth)};
}

}  // namespace scanmill
