#include "report/dataset/scan_counts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "sense/echoes.h"

namespace scanmill {

namespace {

// Returns the size of the upright box with the smallest base that contains the points. Principal axes are not suitable,
// since they are diagonal if points lie on two or three sides of an object. If only two sides are visible, the smallest
// base may be diagonal too, but is then hardly longer than the object.
SeenSize sizeOf(const std::vector<Vec3d>& points, const Box& box) {
  constexpr int kDirections = 30;  // number of directions tried in 90 degrees, 3 degrees apart
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  SeenSize best;
  double smallest = kNothing;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = kPi / 2 * i / kDirections, c = std::cos(angle), s = std::sin(angle);
    double lowU = kNothing, highU = -kNothing, lowV = kNothing, highV = -kNothing;
    for (const Vec3d& p : points) {
      const double u = c * p.x + s * p.y, v = c * p.y - s * p.x;
      lowU = std::min(lowU, u);
      highU = std::max(highU, u);
      lowV = std::min(lowV, v);
      highV = std::max(highV, v);
    }
    const double along = highU - lowU, across = highV - lowV;
    if (along * across >= smallest) continue;
    smallest = along * across;
    best = {std::max(along, across), std::min(along, across), box.high.z - box.low.z};
  }
  return best;
}

bool isElsewhere(std::uint8_t cause) {
  return cause == static_cast<std::uint8_t>(Cause::Mirrored) || cause == static_cast<std::uint8_t>(Cause::StrayLight) ||
         cause == static_cast<std::uint8_t>(Cause::FalsePositive) || cause == static_cast<std::uint8_t>(Cause::Weather);
}

// Measures the boxes of instances. Points whose position is not on the object (mirror images, stray light, false
// positives, weather) are used only if an instance has no other points.
void measure(const Scan& scan, const Mat3& levelFromSensor, std::map<std::uint32_t, InstanceCounts>& instances) {
  if (instances.empty()) return;
  struct Places {
    std::vector<Vec3d> all, ofSurfaces;
  };
  std::unordered_map<std::uint32_t, Places> places;
  const bool told = !scan[kCause].empty();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (scan[kInstance][i] == 0 || !isFinite(scan.position[i])) continue;
    const Vec3d p = levelFromSensor * Vec3d(scan.position[i]);
    Places& own = places[scan[kInstance][i]];
    own.all.push_back(p);
    if (!told || !isElsewhere(scan[kCause][i])) own.ofSurfaces.push_back(p);
  }
  for (auto& [id, own] : instances) {
    const Places& found = places.at(id);
    const std::vector<Vec3d>& points = found.ofSurfaces.empty() ? found.all : found.ofSurfaces;
    for (const Vec3d& p : points) own.box.add(p);
    own.size = sizeOf(points, own.box);
  }
}

}  // namespace

RangeSteps rangeStepsFor(double farthest) {
  constexpr double kMostSteps = 120;
  double step = 0.1;
  for (int i = 0; farthest / step > kMostSteps; ++i) step *= i % 3 == 1 ? 2.5 : 2;
  return {step, static_cast<std::size_t>(std::ceil(std::max(farthest, step) / step)) + 1};
}

std::uint16_t intensityKey(float intensity) {
  return intensity > 0 ? static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(intensity) >> 16) : std::uint16_t{0};
}

float intensityOfKey(std::uint16_t key) {
  return std::bit_cast<float>(std::uint32_t{key} << 16);
}

Mat3 levelFromSensor(const Quat& worldFromSensor) {
  const Mat3 world = toMatrix(worldFromSensor);
  const double yaw = std::hypot(world.x.x, world.x.y) > 1e-6 ? std::atan2(world.x.y, world.x.x) : 0;
  return transposed(toMatrix(fromYawPitchRoll(yaw, 0, 0))) * world;
}

ScanCounts countScan(const Scan& scan, const RangeSteps& steps, const Mat3& levelFromSensor) {
  ScanCounts counts;
  // Counts of the previous point's class; neighbouring points mostly have the same class.
  std::vector<std::uint64_t>* ranges = nullptr;
  std::uint16_t lastClass = 0;
  std::unordered_map<std::uint64_t, std::uint64_t> pairs;  // (id, class) -> number of points
  std::uint64_t lastPair = 0;
  std::uint64_t* pairPoints = nullptr;
  std::vector<std::uint64_t> intensities(scan[kIntensity].empty() ? 0 : std::size_t{1} << 16, 0);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3f& p = scan.position[i];
    if (!isFinite(p)) continue;
    ++counts.points;
    const std::uint16_t label = scan[kLabel].empty() ? std::uint16_t{0} : scan[kLabel][i];
    if (ranges == nullptr || label != lastClass) {
      ranges = &counts.rangesOfClass.try_emplace(label, steps.count, 0).first->second;
      lastClass = label;
    }
    ++(*ranges)[steps.of(length(Vec3d(p)))];
    if (!scan[kIntensity].empty() && std::isfinite(scan[kIntensity][i]))
      ++intensities[intensityKey(scan[kIntensity][i])];
    if (scan[kInstance].empty()) continue;
    const std::uint64_t pair = std::uint64_t{scan[kInstance][i]} << 16 | label;
    if (pairPoints == nullptr || pair != lastPair) {
      pairPoints = &pairs[pair];
      lastPair = pair;
    }
    ++*pairPoints;
  }
  for (std::size_t key = 0; key < intensities.size(); ++key) {
    if (intensities[key] > 0) counts.intensities.emplace(static_cast<std::uint16_t>(key), intensities[key]);
  }
  std::map<std::uint32_t, InstanceCounts> instances;
  for (const auto& [pair, points] : pairs) {
    const auto id = static_cast<std::uint32_t>(pair >> 16);
    const auto label = static_cast<std::uint16_t>(pair & 0xFFFF);
    if (id == 0) {
      counts.withoutId[label] = points;
      continue;
    }
    InstanceCounts& own = instances[id];
    own.id = id;
    own.pointsOfClass[label] = points;
  }
  measure(scan, levelFromSensor, instances);
  for (auto& [id, own] : instances) counts.instances.push_back(std::move(own));
  return counts;
}

}  // namespace scanmill
