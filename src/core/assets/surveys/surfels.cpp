#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nanoflann.hpp>
#include <tuple>

#include "assets/surveys/surveys.h"
#include "base/parallel.h"

namespace scanmill {
namespace {

// Points lie on a line if their second-largest spread is below this fraction of the largest; chosen by eye.
constexpr double kLineSpread = 0.02;
constexpr int kMostFactor = 8;  // largest factor by which the number of neighbours grows

// An adapter with the interface that nanoflann requires of a set of points.
struct Points {
  const std::vector<Vec3f>& positions;
  std::size_t kdtree_get_point_count() const { return positions.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    const Vec3f& p = positions[i];
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3, std::uint32_t>;

// The nearest points of a point, the nearest first, which is the point itself.
struct Neighborhood {
  std::vector<std::uint32_t> indices;
  std::vector<float> squaredDistances;  // m^2
};

class Estimator {
 public:
  Estimator(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals, const SurfelOptions& options)
      : positions_(positions), normals_(normals), options_(options), points_{positions}, tree_(3, points_) {}

  // Returns the surfel of point i: facing up and as large as allowed if the point is alone. `near` is storage.
  Surfel surfelOf(std::size_t i, Neighborhood& near) const {
    const auto count = static_cast<std::size_t>(options_.neighbors) + 1;  // neighbours and the point itself
    Surfel surfel{{0, 0, 1}, static_cast<float>(options_.radius[1])};
    std::size_t found = search(i, count, near);
    if (found < 2) return surfel;
    const double area = kPi * static_cast<double>(near.squaredDistances[found - 1]) / static_cast<double>(found - 1);
    surfel.radius =
        static_cast<float>(std::clamp(options_.cover * std::sqrt(area / kPi), options_.radius[0], options_.radius[1]));
    if (!normals_.empty() && length(Vec3d(normals_[i])) > 0.5) {
      surfel.normal = static_cast<Vec3f>(normalized(Vec3d(normals_[i])));
      return surfel;
    }
    for (std::size_t factor = 1;; factor *= 2) {
      const bool isPlane = fitPlane(near, found, surfel.normal);
      if (isPlane || factor >= kMostFactor || found < count * factor) return surfel;
      found = search(i, count * factor * 2, near);
    }
  }

 private:
  // Fills `near` with the `count` points nearest to point i. Returns their number, which is smaller in a smaller cloud.
  std::size_t search(std::size_t i, std::size_t count, Neighborhood& near) const {
    near.indices.resize(count);
    near.squaredDistances.resize(count);
    return tree_.knnSearch(&positions_[i].x, count, near.indices.data(), near.squaredDistances.data());
  }

  // Fits a plane to the first `count` points of `near` and sets `normal`. Returns false if the points lie on a line.
  bool fitPlane(const Neighborhood& near, std::size_t count, Vec3f& normal) const {
    const Vec3d first(positions_[near.indices[0]]);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3d offset = Vec3d(positions_[near.indices[k]]) - first;
      const Eigen::Vector3d p(offset.x, offset.y, offset.z);
      sum += p;
      squares += p * p.transpose();
    }
    const Eigen::Vector3d mean = sum / static_cast<double>(count);
    const Eigen::Matrix3d covariance = squares / static_cast<double>(count) - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(covariance);
    const Eigen::Vector3d n = solver.eigenvectors().col(0);
    if (!n.allFinite() || n.norm() < 0.5) return false;
    normal = {static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())};
    return solver.eigenvalues()[1] > kLineSpread * kLineSpread * solver.eigenvalues()[2];
  }

  const std::vector<Vec3f>& positions_;
  const std::vector<Vec3f>& normals_;
  const SurfelOptions& options_;
  Points points_;
  Tree tree_;
};

}  // namespace

std::vector<Surfel> surfelsOf(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals,
                              const SurfelOptions& options) {
  std::vector<Surfel> surfels(positions.size());
  if (positions.empty()) return surfels;
  const Estimator estimator(positions, normals, options);
  parallelFor(positions.size(), 1024, [&](std::size_t first, std::size_t last) {
    Neighborhood near;
    for (std::size_t i = first; i < last; ++i) surfels[i] = estimator.surfelOf(i, near);
  });
  return surfels;
}

std::vector<std::size_t> thinned(const std::vector<Vec3f>& positions, double spacing) {
  struct Point {
    std::array<std::int64_t, 3> cube;  // cube of the grid
    double distance;                   // from the cube's centre (cube edges)
    std::size_t index;
  };
  std::vector<Point> points(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3d p = Vec3d(positions[i]) * (1 / spacing);
    const Vec3d low{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    points[i] = {
        {std::llround(low.x), std::llround(low.y), std::llround(low.z)}, length(p - low - Vec3d{0.5, 0.5, 0.5}), i};
  }
  std::ranges::sort(points, {}, [](const Point& p) { return std::tie(p.cube, p.distance, p.index); });
  const auto duplicates = std::ranges::unique(points, {}, &Point::cube);  // all but the first of each cube
  points.erase(duplicates.begin(), duplicates.end());
  std::vector<std::size_t> indices;
  for (const Point& point : points) indices.push_back(point.index);
  std::ranges::sort(indices);
  return indices;
}

}  // namespace scanmill
