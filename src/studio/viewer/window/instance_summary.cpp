#include "viewer/window/instance_summary.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace scanmill {

namespace {

double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Corners of the convex hull, counterclockwise (A. M. Andrew, Inf. Proc. Letters 9, 1979).
std::vector<Vec2d> hullOf(std::vector<Vec2d> places) {
  std::sort(places.begin(), places.end(),
            [](const Vec2d& a, const Vec2d& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
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

// Sides of the rectangle of least area, the longer one first: one of its sides lies along a side of the hull
// (H. Freeman and R. Shapira, Comm. ACM 18, 1975).
Vec2d smallestRectangle(const std::vector<Vec2d>& hull) {
  Vec2d best{0, 0};
  double least = -1;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2d& from = hull[i];
    const Vec2d& to = hull[(i + 1) % hull.size()];
    const double side = std::hypot(to.x - from.x, to.y - from.y);
    if (!(side > 0)) continue;
    const Vec2d along{(to.x - from.x) / side, (to.y - from.y) / side};
    double low = 0, high = 0, far = 0;
    for (const Vec2d& p : hull) {
      const double x = p.x - from.x, y = p.y - from.y;
      low = std::min(low, x * along.x + y * along.y);
      high = std::max(high, x * along.x + y * along.y);
      far = std::max(far, std::abs(y * along.x - x * along.y));
    }
    const double area = (high - low) * far;
    if (least >= 0 && area >= least) continue;
    least = area;
    best = {std::max(high - low, far), std::min(high - low, far)};
  }
  return best;
}

}  // namespace

InstanceSummary summarizeInstance(const Scan& scan, std::uint32_t instance, const Affine& levelFromScan) {
  InstanceSummary summary;
  summary.id = instance;
  std::map<std::uint16_t, std::uint64_t> classes;
  std::vector<Vec2d> places;
  double low = 0, high = 0;
  for (std::size_t i = 0; i < scan[kInstance].size(); ++i) {
    if (scan[kInstance][i] != instance || !isFinite(scan.position[i])) continue;
    const Vec3d p = levelFromScan * Vec3d(scan.position[i]);
    low = places.empty() ? p.z : std::min(low, p.z);
    high = places.empty() ? p.z : std::max(high, p.z);
    places.push_back({p.x, p.y});
    summary.points.push_back(static_cast<std::uint32_t>(i));
    if (!scan[kLabel].empty()) ++classes[scan[kLabel][i]];
  }
  summary.classes.assign(classes.begin(), classes.end());
  std::stable_sort(summary.classes.begin(), summary.classes.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  const Vec2d sides = smallestRectangle(hullOf(std::move(places)));
  summary.size = {sides.x, sides.y, high - low};
  return summary;
}

}  // namespace scanmill
