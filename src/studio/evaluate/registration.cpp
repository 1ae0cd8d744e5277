// PCL's libraries are built for any x86-64 processor, for which Eigen aligns to 16 bytes. If our compiler flags enabled
// wider vector instructions, Eigen would align differently, and PCL's classes would have another layout in our code
// than in PCL's. Vector instructions would not help anyway, since most of the time is spent in nearest-neighbour
// search.
#define EIGEN_MAX_ALIGN_BYTES 16
#define EIGEN_DONT_VECTORIZE

#include "evaluate/registration.h"

#include <pcl/console/print.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <nanoflann.hpp>
#include <vector>

#include "evaluate/spread.h"

namespace scanmill {

namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr std::size_t kLeastPoints = 3;  // minimum number of points from which PCL computes a rigid motion

// Returns the finite points relative to `middle`. Near the origin, the float32 rotations of ICP cause smaller errors.
PclCloud::Ptr finiteCloud(std::span<const Vec3f> points, const Vec3f& middle) {
  PclCloud::Ptr cloud(new PclCloud);
  for (const Vec3f& p : points) {
    const Vec3f relative = p - middle;
    if (isFinite(p)) cloud->push_back({relative.x, relative.y, relative.z});
  }
  return cloud;
}

// Returns the mean of the finite points; the origin if there are none.
Vec3f meanPoint(std::span<const Vec3f> points) {
  Vec3d sum;
  std::size_t count = 0;
  for (const Vec3f& p : points) {
    if (!isFinite(p)) continue;
    sum += static_cast<Vec3d>(p);
    ++count;
  }
  return count == 0 ? Vec3f{} : static_cast<Vec3f>(sum * (1.0 / static_cast<double>(count)));
}

// A cloud with the functions that nanoflann calls to read it.
struct PclPoints {
  const PclCloud& cloud;

  std::size_t kdtree_get_point_count() const { return cloud.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return cloud[i].data[axis]; }
  template <class Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;
  }
};

// A nearest-neighbour search for PCL. PCL's own search starts a team of OpenMP threads for every point and takes three
// times as long. Both searches are exact.
class NearestPoints : public pcl::search::KdTree<pcl::PointXYZ> {
 public:
  explicit NearestPoints(PclCloud::ConstPtr cloud) : cloud_(std::move(cloud)), points_{*cloud_}, tree_(3, points_) {
    input_ = cloud_;
  }

  using pcl::search::KdTree<pcl::PointXYZ>::nearestKSearch;
  int nearestKSearch(const pcl::PointXYZ& point, int count, pcl::Indices& indices,
                     std::vector<float>& squares) const override {
    indices.resize(static_cast<std::size_t>(count));
    squares.resize(static_cast<std::size_t>(count));
    return static_cast<int>(
        tree_.knnSearch(point.data, static_cast<std::size_t>(count), indices.data(), squares.data()));
  }

 private:
  using Index =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PclPoints>, PclPoints, 3, pcl::index_t>;
  PclCloud::ConstPtr cloud_;
  PclPoints points_;
  Index tree_;
};

// A pair of clouds for PCL. Both are relative to the target's mean point. The search tree is used for fitness and ICP.
class PclPair {
 public:
  PclPair(std::span<const Vec3f> source, std::span<const Vec3f> target)
      : source_(finiteCloud(source, meanPoint(target))), target_(finiteCloud(target, meanPoint(target))) {
    if (source_->empty() || target_->empty()) return;
    icp_.setInputSource(source_);
    icp_.setInputTarget(target_);
    icp_.setSearchMethodTarget(NearestPoints::Ptr(new NearestPoints(target_)), true);
  }

  // Returns the fitness (m^2) of the source as moved by the last align(); nothing if a cloud has no points.
  std::optional<double> fitness() {
    if (source_->empty() || target_->empty()) return std::nullopt;
    return icp_.getFitnessScore();
  }

  // Moves the source onto the target by ICP. Returns false if ICP finds no motion.
  bool align(int iterations) {
    if (source_->size() < kLeastPoints || target_->size() < kLeastPoints) return false;
    // Turns off PCL's messages. The expected message, about too few matches, is not needed: see Registered::moved.
    static std::once_flag silenced;
    std::call_once(silenced, pcl::console::setVerbosityLevel, pcl::console::L_ALWAYS);
    icp_.setMaximumIterations(iterations);
    PclCloud moved;
    icp_.align(moved);
    return icp_.hasConverged() && icp_.getFinalTransformation().allFinite();
  }

 private:
  PclCloud::Ptr source_, target_;
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp_;
};

}  // namespace

Registered registerClouds(std::span<const Vec3f> source, std::span<const Vec3f> target, int iterations) {
  PclPair pair(source, target);
  const std::optional<double> unmoved = pair.fitness();
  if (!pair.align(iterations)) return {.unmoved = unmoved, .fitness = unmoved};
  return {.moved = true, .unmoved = unmoved, .fitness = pair.fitness()};
}

FitnessSpread fitnessSpread(std::span<const std::optional<double>> values) {
  std::vector<double> present;
  for (const std::optional<double>& v : values) {
    if (v) present.push_back(*v);
  }
  if (present.empty()) return {};
  return {.count = present.size(),
          .mean = meanOf(present),
          .deviation = deviationOf(present),
          .low = std::ranges::min(present),
          .high = std::ranges::max(present)};
}

}  // namespace scanmill
