#include "evaluate/cloud_distance.h"

#include <cmath>
#include <nanoflann.hpp>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

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

}  // namespace

std::vector<double> distancesToNearest(std::span<const Vec3f> from, std::span<const Vec3f> to) {
  const Cloud target = finitePoints(to);
  if (target.points.empty()) throw Error("the distance cannot be measured to a cloud without points");
  const Tree tree(3, target);
  const std::vector<Vec3f> queries = finitePoints(from).points;
  std::vector<double> distances(queries.size());
  parallelFor(queries.size(), 1024, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      std::uint32_t index = 0;
      float square = 0;
      tree.knnSearch(&queries[i].x, 1, &index, &square);
      distances[i] = std::sqrt(double{square});
    }
  });
  return distances;
}

Spread nearestDistances(std::span<const Vec3f> from, std::span<const Vec3f> to) {
  return spreadOf(distancesToNearest(from, to));
}

}  // namespace scanmill
