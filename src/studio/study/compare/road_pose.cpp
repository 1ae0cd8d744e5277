#include "study/compare/road_pose.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "evaluate/spread.h"
#include "study/linear_fit.h"

namespace scanmill {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Words for the simulated sensor's difference in a figure, and the smallest difference that counts.
struct DifferenceWords {
  std::string_view more, less;
  double least;
};
constexpr std::array<DifferenceWords, kRoadFigureCount> kDifferenceWords{
    {{"farther down", "less down", 0.05},
     {"higher on the left", "lower on the left", 0.05},
     {"higher", "lower", 0.01},
     {"more to the left", "less to the left", 0.05},
     {"farther", "nearer", 0.25},
     {"farther", "nearer", 0.25}}};

// Fits a plane, then three times without the points that are far from the previous plane. Returns nothing if the points
// are too few.
std::optional<LevelPlane> robustPlane(const std::vector<Vec3d>& points) {
  constexpr std::size_t kFewestPoints = 30;
  constexpr double kOutlierRatio = 3;      // multiple of the median distance from the plane
  constexpr double kLeastDistance = 0.02;  // m, nearer points are no outliers
  if (points.size() < kFewestPoints) return {};
  LevelPlane plane(points);
  for (int round = 0; round < 3; ++round) {
    std::vector<double> distances;
    distances.reserve(points.size());
    for (const Vec3d& p : points) distances.push_back(std::fabs(plane.heightAbove(p)));
    const double limit = std::max(kOutlierRatio * medianOf(std::move(distances)), kLeastDistance);
    std::vector<Vec3d> inliers;
    std::ranges::copy_if(points, std::back_inserter(inliers),
                         [&](const Vec3d& p) { return std::fabs(plane.heightAbove(p)) <= limit; });
    plane = LevelPlane(inliers);
  }
  return plane;
}

// Returns the ids of the ontology's classes of ground; true for those of the road.
std::map<std::uint16_t, bool> groundClasses(const Ontology& ontology) {
  std::map<std::uint16_t, bool> isRoad;
  for (const std::string_view name :
       {"road", "road_marking", "sidewalk", "curb", "terrain", "ground", "parking", "driveway"}) {
    const SemanticClass* const found = ontology.find(name);
    if (found != nullptr) isRoad.emplace(found->id, name.starts_with("road"));
  }
  return isRoad;
}

// Strips along one side of the vehicle, from the vehicle outwards.
constexpr double kStripWidth = 0.25;                        // m
using Strips = std::array<std::array<std::size_t, 2>, 80>;  // numbers of points beside and on the road

// Returns the distance (m) of the road's edge; NaN if no strip is beyond it.
double edgeOf(const Strips& strips) {
  constexpr std::size_t kFirst = 2, kFewestPoints = 10;
  for (std::size_t i = kFirst; i < strips.size(); ++i) {
    const auto [beside, onRoad] = strips[i];
    if (beside + onRoad >= kFewestPoints && beside > onRoad) return kStripWidth * static_cast<double>(i);
  }
  return kUnknown;
}

}  // namespace

LevelPlane::LevelPlane(const std::vector<Vec3d>& points) {
  std::vector<double> design, heights;
  heights.reserve(points.size());
  for (const Vec3d& p : points) {
    design.insert(design.end(), {1, p.y, p.x});
    heights.push_back(p.z);
  }
  const LinearFit fit = fitLinear(design, 3, heights);
  height = fit.coefficients[0];
  left = fit.coefficients[1];
  ahead = fit.coefficients[2];
  deviation = std::sqrt(fit.squares / static_cast<double>(fit.freedom()));
}

std::vector<Vec3d> groundAmong(std::vector<Vec3d> points) {
  constexpr double kLeastDepth = 0.3;    // m below the sensor
  constexpr double kMostDistance = 0.5;  // m from the plane
  constexpr double kLargeCell = 4;       // m
  constexpr std::size_t kFewestPoints = 200, kFewestCells = 8;
  std::erase_if(points, [](const Vec3d& p) { return p.z >= -kLeastDepth; });
  if (points.size() < kFewestPoints) return {};
  std::map<std::pair<double, double>, Vec3d> lowest;  // lowest point by cell
  for (const Vec3d& p : points) {
    Vec3d& ofCell = lowest.try_emplace({std::floor(p.x / kLargeCell), std::floor(p.y / kLargeCell)}, p).first->second;
    if (p.z < ofCell.z) ofCell = p;
  }
  if (lowest.size() < kFewestCells) return {};
  std::vector<Vec3d> ground;
  ground.reserve(lowest.size());
  for (const auto& [cell, point] : lowest) ground.push_back(point);
  for (int round = 0; round < 3; ++round) {
    const LevelPlane plane(ground);
    ground.clear();
    std::ranges::copy_if(points, std::back_inserter(ground),
                         [&](const Vec3d& p) { return std::fabs(plane.heightAbove(p)) < kMostDistance; });
    if (ground.size() < kFewestPoints) return {};
  }
  return ground;
}

RoadPose roadPoseOf(const Scan& scan, const Ontology* ontology, double heading) {
  constexpr double kNearest = 3, kFarthest = 12;  // m, horizontal distances between which the ground is measured
  constexpr double kHalfLane = 1.3;               // m, farthest beside the sensor at which its lane is measured
  constexpr double kAlongEdge = 10;               // m, farthest ahead and behind at which edges are searched for
  constexpr double kFarthestEdge = kStripWidth * std::tuple_size_v<Strips>;
  const bool byClass = ontology != nullptr && !scan[kLabel].empty();
  const std::map<std::uint16_t, bool> isRoad = byClass ? groundClasses(*ontology) : std::map<std::uint16_t, bool>();
  const Mat3 vehicleFromScan = toMatrix(fromYawPitchRoll(-heading, 0, 0));
  std::vector<Vec3d> ground, lane;
  Strips left{}, right{};
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3d p = vehicleFromScan * Vec3d(scan.position[i]);
    const double distance = std::hypot(p.x, p.y);
    if (!isFinite(scan.position[i]) || distance >= kFarthestEdge) continue;
    const auto found = byClass ? isRoad.find(scan[kLabel][i]) : isRoad.end();
    if (byClass && found == isRoad.end()) continue;
    if (byClass && std::fabs(p.x) < kAlongEdge) {
      ++(p.y > 0 ? left : right)[static_cast<std::size_t>(std::fabs(p.y) / kStripWidth)][found->second ? 1 : 0];
    }
    if (distance >= kNearest && distance <= kFarthest && (!byClass || found->second)) ground.push_back(p);
  }
  if (!byClass) ground = groundAmong(std::move(ground));
  std::ranges::copy_if(ground, std::back_inserter(lane), [](const Vec3d& p) { return std::fabs(p.y) < kHalfLane; });
  RoadPose pose;
  pose.fill(kUnknown);
  pose[kLeftEdge] = edgeOf(left);
  pose[kRightEdge] = edgeOf(right);
  if (const std::optional<LevelPlane> plane = robustPlane(ground)) {
    const double normal = std::sqrt(1 + plane->ahead * plane->ahead + plane->left * plane->left);
    pose[kPitch] = degrees(std::asin(plane->ahead / normal));
    pose[kRoll] = degrees(std::atan(-plane->left));
    pose[kHeight] = -plane->height / normal;
  }
  if (const std::optional<LevelPlane> plane = robustPlane(lane)) pose[kLaneSlope] = degrees(std::atan(plane->left));
  return pose;
}

RoadPoses spreadsOf(const std::vector<RoadPose>& poses, const std::vector<std::string>& sequences) {
  constexpr std::size_t kFewestSequences = 3;
  RoadPoses spreads;
  for (std::size_t f = 0; f < kRoadFigureCount; ++f) {
    std::vector<double> values, medians;
    values.reserve(poses.size());
    std::map<std::string, std::vector<double>> bySequence;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      values.push_back(poses[i][f]);
      if (!std::isnan(values[i])) bySequence[sequences[i]].push_back(values[i]);
    }
    medians.reserve(bySequence.size());
    for (const auto& [sequence, ofSequence] : bySequence) medians.push_back(medianOf(ofSequence));
    double squares = 0;
    for (const double median : medians) squares += std::pow(median - meanOf(medians), 2);
    const auto freedom = static_cast<double>(medians.size()) - 1;
    spreads[f] = {.median = quantileOf(values, 0.5),
                  .lowerQuartile = quantileOf(values, 0.25),
                  .upperQuartile = quantileOf(values, 0.75),
                  .spread = (quantileOf(values, 0.84) - quantileOf(values, 0.16)) / 2,
                  .overSequences = medians.size() < kFewestSequences ? kUnknown : std::sqrt(squares / freedom)};
  }
  return spreads;
}

std::string differenceText(std::size_t figure, const RoadPoses& real, const RoadPoses& simulated) {
  const double difference = simulated[figure].median - real[figure].median;
  const DifferenceWords& words = kDifferenceWords[figure];
  if (!(std::fabs(difference) > std::max(real[figure].spread, words.least))) return {};
  return fmt::format("{:.2g} {} {}", std::fabs(difference), kRoadFigures[figure].unit,
                     difference > 0 ? words.more : words.less);
}

}  // namespace scanmill
