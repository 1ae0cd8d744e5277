#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
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
constexpr std::size_t kNeighbors = 12;  // number of neighbours from which normal and radius are estimated
constexpr int kMostFactor = 8;          // largest factor by which the number of neighbours grows

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

// The points nearest to a point, ordered by distance. The first one is the point itself.
struct Neighborhood {
  std::vector<std::uint32_t> indices;
  std::vector<float> squaredDistances;  // m^2
};

// Fills `near` with the `count` points nearest to a position, or with all points of a smaller cloud.
void search(const Tree& tree, const Vec3f& position, std::size_t count, Neighborhood& near) {
  near.indices.resize(count);
  near.squaredDistances.resize(count);
  count = tree.knnSearch(&position.x, count, near.indices.data(), near.squaredDistances.data());
  near.indices.resize(count);
  near.squaredDistances.resize(count);
}

// Fits a plane to the points with these indices and sets `normal`. Returns false if they lie on a line.
bool fitPlane(const std::vector<Vec3f>& positions, const std::vector<std::uint32_t>& indices, Vec3f& normal) {
  const Vec3d first(positions[indices[0]]);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const std::uint32_t index : indices) {
    const Vec3d offset = Vec3d(positions[index]) - first;
    const Eigen::Vector3d p(offset.x, offset.y, offset.z);
    sum += p;
    squares += p * p.transpose();
  }
  const auto count = static_cast<double>(indices.size());
  const Eigen::Vector3d mean = sum / count;
  const Eigen::Matrix3d covariance = squares / count - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d n = solver.eigenvectors().col(0);
  if (!n.allFinite() || n.norm() < 0.5) return false;
  normal = {static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())};
  return solver.eigenvalues()[1] > kLineSpread * kLineSpread * solver.eigenvalues()[2];
}

// Returns the surfel of point i. If the cloud has only this point, its surfel faces up and has the greatest radius.
// `normal`: the point's normal, zero if unknown. `near`: storage for searches.
Surfel surfelOf(const Tree& tree, const std::vector<Vec3f>& positions, std::size_t i, const Vec3d& normal,
                const SurfelOptions& options, Neighborhood& near) {
  const auto count = kNeighbors + 1;  // neighbours and the point itself
  const auto [leastRadius, greatestRadius] = options.radius;
  Surfel surfel{{0, 0, 1}, static_cast<float>(greatestRadius)};
  search(tree, positions[i], count, near);
  if (near.indices.size() < 2) return surfel;
  const auto neighbors = static_cast<double>(near.indices.size() - 1);
  const double area = kPi * static_cast<double>(near.squaredDistances.back()) / neighbors;
  surfel.radius = static_cast<float>(std::clamp(options.cover * std::sqrt(area / kPi), leastRadius, greatestRadius));
  if (length(normal) > 0.5) {  // 0 or about 1
    surfel.normal = static_cast<Vec3f>(normalized(normal));
    return surfel;
  }
  for (std::size_t factor = 1;; factor *= 2) {
    const bool isPlane = fitPlane(positions, near.indices, surfel.normal);
    if (isPlane || factor >= kMostFactor || near.indices.size() < count * factor) return surfel;
    search(tree, positions[i], count * factor * 2, near);
  }
}

}  // namespace

std::vector<Surfel> surfelsOf(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals,
                              const SurfelOptions& options) {
  std::vector<Surfel> surfels(positions.size());
  if (positions.empty()) return surfels;
  const Points points{positions};
  const Tree tree(3, points);
  parallelFor(positions.size(), 1024, [&](std::size_t first, std::size_t last) {
    Neighborhood near;
    for (std::size_t i = first; i < last; ++i) {
      surfels[i] = surfelOf(tree, positions, i, normals.empty() ? Vec3d{} : Vec3d(normals[i]), options, near);
    }
  });
  return surfels;
}

std::vector<std::size_t> thinned(const std::vector<Vec3f>& positions, double spacing) {
  struct Point {
    std::array<std::int64_t, 3> cube;  // indices of the cube in the grid
    double distance;                   // distance from the cube's centre (cube edges)
    std::size_t index;
  };
  std::vector<Point> points(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3d p = Vec3d(positions[i]) * (1 / spacing);
    const Vec3d low{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    points[i] = {
        {std::llround(low.x), std::llround(low.y), std::llround(low.z)}, length(p - low - Vec3d{0.5, 0.5, 0.5}), i};
  }
  std::ranges::sort(points, [](const Point& a, const Point& b) {
    return a.cube != b.cube ? a.cube < b.cube : std::tie(a.distance, a.index) < std::tie(b.distance, b.index);
  });
  const auto duplicates = std::ranges::unique(points, {}, &Point::cube);  // all points of each cube but the first
  points.erase(duplicates.begin(), duplicates.end());
  std::vector<std::size_t> indices;
  for (const Point& point : points) indices.push_back(point.index);
  std::ranges::sort(indices);
  return indices;
}

}  // namespace scanmill
