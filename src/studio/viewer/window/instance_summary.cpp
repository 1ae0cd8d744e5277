#include "viewer/window/instance_summary.h"

#include <algorithm>
#include <functional>
#include <map>

#include "scene/thing_boxes.h"

namespace scanmill {

namespace {

InstanceSummary summaryOf(const Scan& scan, std::span<const Vec3f> placed, std::uint32_t instance,
                          std::vector<std::uint32_t> points, const Affine& levelFromPlaces) {
  InstanceSummary summary;
  summary.id = instance;
  std::map<std::uint16_t, std::uint64_t> classes;
  std::vector<Vec2d> ground;
  ground.reserve(points.size());
  for (const std::uint32_t i : points) {
    const Vec3d p = levelFromPlaces * Vec3d(placed[i]);
    ground.push_back({p.x, p.y});
    if (!scan[kLabel].empty()) ++classes[scan[kLabel][i]];
  }
  summary.classes.assign(classes.begin(), classes.end());
  std::ranges::stable_sort(summary.classes, std::greater<>(), [](const auto& entry) { return entry.second; });
  summary.levelFromBox.linear = toMatrix(fromYawPitchRoll(longSideOf(std::move(ground)), 0, 0));
  const Mat3 boxFromLevel = transposed(summary.levelFromBox.linear);
  Box box;
  for (const std::uint32_t i : points) box.add(boxFromLevel * (levelFromPlaces * Vec3d(placed[i])));
  if (!box.empty()) {
    summary.size = box.high - box.low;
    summary.levelFromBox.translation = summary.levelFromBox.linear * box.center();
  }
  summary.points = std::move(points);
  return summary;
}

}  // namespace

InstanceSummary summarizeInstance(const Scan& scan, std::span<const Vec3f> places, std::uint32_t instance,
                                  const Affine& levelFromPlaces) {
  std::vector<std::uint32_t> points;
  for (std::size_t i = 0; i < scan[kInstance].size(); ++i) {
    if (scan[kInstance][i] == instance && isFinite(places[i])) points.push_back(static_cast<std::uint32_t>(i));
  }
  return summaryOf(scan, places, instance, std::move(points), levelFromPlaces);
}

std::vector<InstanceSummary> summarizeInstances(const Scan& scan, std::span<const Vec3f> places,
                                                const Affine& levelFromPlaces) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> points;
  for (std::size_t i = 0; i < scan[kInstance].size(); ++i) {
    if (scan[kInstance][i] != 0 && isFinite(places[i])) {
      points[scan[kInstance][i]].push_back(static_cast<std::uint32_t>(i));
    }
  }
  std::vector<InstanceSummary> all;
  all.reserve(points.size());
  for (auto& [id, own] : points) all.push_back(summaryOf(scan, places, id, std::move(own), levelFromPlaces));
  return all;
}

}  // namespace scanmill
