#include "study/compare/road_pose.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "evaluate/spread.h"

namespace scanmill {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Returns the points that are at most `limit` (m) from the plane.
std::vector<Vec3d> pointsNear(const Plane& plane, double limit, std::vector<Vec3d> points) {
  std::erase_if(points, [&](const Vec3d& p) { return std::fabs(plane.distanceOf(p)) > limit; });
  return points;
}

// Fits a plane, then three times without the points that are far from the previous plane. Returns nothing if the points
// are too few.
std::optional<Plane> robustPlane(const std::vector<Vec3d>& points) {
  constexpr std::size_t kFewestPoints = 30;
  constexpr double kOutlierRatio = 3;      // multiple of the median distance from the plane
  constexpr double kLeastDistance = 0.02;  // m, nearer points are no outliers
  if (points.size() < kFewestPoints) return {};
  Plane plane = planeOf(points);
  for (int round = 0; round < 3; ++round) {
    std::vector<double> distances;
    distances.reserve(points.size());
    for (const Vec3d& p : points) distances.push_back(std::fabs(plane.distanceOf(p)));
    const double limit = std::max(kOutlierRatio * medianOf(std::move(distances)), kLeastDistance);
    plane = planeOf(pointsNear(plane, limit, points));
  }
  return plane;
}

double rollOver(const Plane& plane) {
  return degrees(std::atan2(plane.normal.y, plane.normal.z));
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

std::vector<Vec3d> groundAmong(std::vector<Vec3d> points) {
  constexpr double kLeastDepth = 0.3;    // m below the sensor
  constexpr double kMostDistance = 0.5;  // m from the plane
  constexpr double kLargeCell = 4;       // m
  constexpr std::size_t kFewestPoints = 200, kFewestCells = 8;
  std::erase_if(points, [](const Vec3d& p) { return p.z >= -kLeastDepth; });
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
    ground = pointsNear(planeOf(ground), kMostDistance, points);
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
  std::vector<Vec3d> ground;
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
  RoadPose pose;
  pose.fill(kUnknown);
  pose[kLeftEdge] = edgeOf(left);
  pose[kRightEdge] = edgeOf(right);
  if (const std::optional<Plane> plane = robustPlane(ground)) {
    pose[kPitch] = -degrees(std::asin(plane->normal.x));
    pose[kRoll] = rollOver(*plane);
    pose[kHeight] = plane->distanceOf({});
  }
  std::erase_if(ground, [](const Vec3d& p) { return std::fabs(p.y) >= kHalfLane; });
  if (const std::optional<Plane> lane = robustPlane(ground)) pose[kLaneSlope] = -rollOver(*lane);
  return pose;
}

RoadPoses spreadsOf(const PosesBySequence& poses) {
  constexpr std::size_t kFewestSequences = 3;
  RoadPoses spreads;
  for (std::size_t f = 0; f < kRoadFigureCount; ++f) {
    std::vector<double> values, medians;  // of the scans; of the sequences
    for (const auto& [sequence, ofSequence] : poses) {
      std::vector<double> inSequence;
      inSequence.reserve(ofSequence.size());
      for (const RoadPose& pose : ofSequence) inSequence.push_back(pose[f]);
      values.insert(values.end(), inSequence.begin(), inSequence.end());
      medians.push_back(quantileOf(std::move(inSequence), 0.5));
    }
    std::erase_if(medians, [](double median) { return std::isnan(median); });
    spreads[f] = {.median = quantileOf(values, 0.5),
                  .low = quantileOf(values, 0.16),
                  .high = quantileOf(values, 0.84),
                  .overSequences = medians.size() < kFewestSequences ? kUnknown : deviationOf(medians)};
  }
  return spreads;
}

std::string differenceText(std::size_t figure, const RoadPoses& real, const RoadPoses& simulated) {
  const ComparedFigure& words = kRoadFigures[figure];
  const double difference = simulated[figure].median - real[figure].median;
  const double usual = std::max((real[figure].high - real[figure].low) / 2, words.leastDifference);
  if (!(std::fabs(difference) > usual)) return {};
  return fmt::format("{:.2g} {} {}", std::fabs(difference), words.unit, difference > 0 ? words.more : words.less);
}

}  // namespace scanmill
