#include "viewer/window/instance_summary.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace scanmill {

namespace {

double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Returns the corners of the places' convex hull, counterclockwise (A. M. Andrew, Inf. Proc. Letters 9, 1979).
std::vector<Vec2d> hullOf(std::vector<Vec2d> places) {
  std::ranges::sort(places, {}, [](const Vec2d& p) { return std::pair(p.x, p.y); });
  places.erase(std::unique(places.begin(), places.end()), places.end());
  if (places.size() < 3) return places;
  std::vector<Vec2d> hull;
  const auto add = [&](const Vec2d& p, std::size_t kept) {
    while (hull.size() >= kept + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
    hull.push_back(p);
  };
  for (const Vec2d& p : places) add(p, 0);
  const std::size_t upper = hull.size() - 1;
  for (std::size_t i = places.size() - 1; i-- > 0;) add(places[i], upper);
  hull.pop_back();
  return hull;
}

struct FlatBox {
  Vec2d middle{0, 0};
  Vec2d sides{0, 0};   // lengths of the sides (m), the longer side first
  double heading = 0;  // heading of the longer side (rad)
};

// Returns the rectangle of least area that encloses the hull. One of its sides is along a side of the hull (H. Freeman
// and R. Shapira, Comm. ACM 18, 1975).
FlatBox smallestRectangle(const std::vector<Vec2d>& hull) {
  FlatBox best;
  if (hull.size() == 1) best.middle = hull.front();
  double least = -1;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2d& from = hull[i];
    const Vec2d& to = hull[(i + 1) % hull.size()];
    const double side = std::hypot(to.x - from.x, to.y - from.y);
    if (!(side > 0)) continue;
    const Vec2d along{(to.x - from.x) / side, (to.y - from.y) / side};
    double low = 0, high = 0, far = 0;  // extent along the side, and to the left of it, where the hull lies
    for (const Vec2d& p : hull) {
      const double x = p.x - from.x, y = p.y - from.y;
      low = std::min(low, x * along.x + y * along.y);
      high = std::max(high, x * along.x + y * along.y);
      far = std::max(far, y * along.x - x * along.y);
    }
    const double area = (high - low) * far;
    if (least >= 0 && area >= least) continue;
    least = area;
    const double middle = (low + high) / 2;
    best.middle = {from.x + middle * along.x - far / 2 * along.y, from.y + middle * along.y + far / 2 * along.x};
    const bool turned = far > high - low;
    best.heading = std::atan2(along.y, along.x) + (turned ? kPi / 2 : 0);
    best.sides = turned ? Vec2d{far, high - low} : Vec2d{high - low, far};
  }
  return best;
}

InstanceSummary summaryOf(const Scan& scan, std::span<const Vec3f> placed, std::uint32_t instance,
                          std::vector<std::uint32_t> points, const Affine& levelFromPlaces) {
  InstanceSummary summary;
  summary.id = instance;
  std::map<std::uint16_t, std::uint64_t> classes;
  std::vector<Vec2d> places;
  places.reserve(points.size());
  double low = 0, high = 0;
  for (const std::uint32_t i : points) {
    const Vec3d p = levelFromPlaces * Vec3d(placed[i]);
    low = places.empty() ? p.z : std::min(low, p.z);
    high = places.empty() ? p.z : std::max(high, p.z);
    places.push_back({p.x, p.y});
    if (!scan[kLabel].empty()) ++classes[scan[kLabel][i]];
  }
  summary.points = std::move(points);
  summary.classes.assign(classes.begin(), classes.end());
  std::ranges::stable_sort(summary.classes, std::greater<>(), [](const auto& entry) { return entry.second; });
  const FlatBox flat = smallestRectangle(hullOf(std::move(places)));
  summary.size = {flat.sides.x, flat.sides.y, high - low};
  summary.levelFromBox = {toMatrix(fromYawPitchRoll(flat.heading, 0, 0)),
                          {flat.middle.x, flat.middle.y, (low + high) / 2}};
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
