#include "town/lanes.h"

#include <algorithm>
#include <cmath>

#include "town/placer.h"

namespace scanmill::town {

namespace {

constexpr double kPoints = 6;  // m between the points of a lane

// Returns points that continue a way beyond the end of a road: down, in a half circle, and back far below the ground,
// where vehicles are hidden before they arrive or after they have left.
std::vector<Vec3d> wayBelow(const Vec3d& end, const Vec3d& next, double reach) {
  std::vector<Vec3d> more;
  if (reach <= 0) return more;
  Vec3d ahead = end - next;
  ahead.z = 0;
  ahead = normalized(ahead);
  const Vec3d aside{-ahead.y, ahead.x, 0};
  constexpr double kRamp = 130;  // m, horizontal length of the ramp down
  constexpr double kDepth = 70;
  constexpr double kTurn = 20;  // m, radius of the half circle
  for (const double d : models::steps(10, kRamp, 10)) {
    more.push_back(end + ahead * d + Vec3d{0, 0, -kDepth * models::smooth(d / kRamp)});
  }
  const Vec3d bottom = end + ahead * kRamp + Vec3d{0, 0, -kDepth};
  for (int k = 0; k <= 6; ++k) {
    const double angle = kPi * k / 6;
    more.push_back(bottom + ahead * (kTurn * std::sin(angle)) + aside * (kTurn * (1 - std::cos(angle))));
  }
  for (const double d : models::steps(15, reach - kRamp, 40)) more.push_back(bottom + aside * (2 * kTurn) - ahead * d);
  return more;
}

}  // namespace

LaidOut layOut(const Layout& l, const Way& way, double out, double least) {
  LaidOut laid;
  std::vector<Vec3d> points;
  for (const Way::Stretch& s : way.stretches) {
    const Road& road = l.roads()[s.road];
    const double direction = s.to >= s.from ? 1 : -1;
    const double lateral = road.oneWay() ? out : std::max(road.laneMiddle() + out, least);
    const auto count = std::max(1, static_cast<int>(std::abs(s.to - s.from) / kPoints));
    for (int k = 0; k <= count; ++k) {
      const double along = s.from + (s.to - s.from) * k / count;
      points.push_back(l.onGround(besideRoad(road, along, -direction * lateral).at));
      laid.places.push_back({s.road, along});
    }
  }
  const std::vector<Vec3d> behind = wayBelow(points[points.size() - 1], points[points.size() - 2], way.after);
  const std::vector<Vec3d> before = wayBelow(points[0], points[1], way.before);
  laid.first = before.size();
  laid.points.assign(before.rbegin(), before.rend());
  laid.points.insert(laid.points.end(), points.begin(), points.end());
  laid.points.insert(laid.points.end(), behind.begin(), behind.end());
  return laid;
}

double mouthOf(const Layout& l) {
  return l.mainRoad().section.half + 7;
}

double stopAtMouth(const Layout& l) {
  return mouthOf(l) - 4;
}

double endOf(const Road& sideRoad) {
  return sideRoad.length() - 6;
}

double cornerOf(const Road& sideRoad) {
  return sideRoad.section.half + 6;
}

Tour tourOf(const Layout& l) {
  constexpr double kLeast = 30;  // m, least length of the main road between two turns, or before the only turn
  Tour tour;
  for (const Road& road : l.roads()) {
    if (!road.joins || road.joinsLeft || endOf(road) < mouthOf(l) + 20) continue;
    if (road.along && (tour.into == nullptr || *road.joins > *tour.into->joins)) tour.into = &road;
    if (road.against && (tour.from == nullptr || *road.joins < *tour.from->joins)) tour.from = &road;
  }
  if (tour.into != nullptr && tour.from != nullptr &&
      *tour.into->joins - *tour.from->joins < cornerOf(*tour.from) + cornerOf(*tour.into) + kLeast) {
    tour.from = nullptr;
  }
  // Without `from` the vehicle must not turn within kLeast of the start of the built-up part.
  if (tour.into != nullptr && tour.from == nullptr && *tour.into->joins - cornerOf(*tour.into) < l.mainFrom + kLeast) {
    tour.into = nullptr;
  }
  return tour;
}

}  // namespace scanmill::town
