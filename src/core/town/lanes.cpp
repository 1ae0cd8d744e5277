#include "town/lanes.h"

#include <algorithm>
#include <cmath>

#include "town/placer.h"

namespace scanmill::town {

namespace {

constexpr double kPointDistance = 6;  // m between the points of a path

// Returns points that continue a path beyond the end of a road: down, in a half circle, and back far below the ground,
// where vehicles are hidden before they arrive or after they have left.
std::vector<Vec3d> hiddenPath(const Vec3d& end, const Vec3d& beforeEnd, double reach) {
  std::vector<Vec3d> more;
  if (reach <= 0) return more;
  Vec3d ahead = end - beforeEnd;
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

LanePoints lanePoints(const Layout& l, const LanePath& path, double out, double least) {
  LanePoints made;
  std::vector<Vec3d> onRoads;
  for (const RoadInterval& s : path.intervals) {
    const Road& road = l.roads()[s.road];
    const double direction = s.to >= s.from ? 1 : -1;
    const double lateral = road.oneWay() ? out : std::max(road.laneMiddle() + out, least);
    const auto count = std::max(1, static_cast<int>(std::abs(s.to - s.from) / kPointDistance));
    for (int k = 0; k <= count; ++k) {
      const double along = s.from + (s.to - s.from) * k / count;
      onRoads.push_back(l.onGround(besideRoad(road, along, -direction * lateral).at));
      made.positions.push_back({s.road, along});
    }
  }
  const std::vector<Vec3d> after =
      hiddenPath(onRoads[onRoads.size() - 1], onRoads[onRoads.size() - 2], path.hiddenAfter);
  const std::vector<Vec3d> before = hiddenPath(onRoads[0], onRoads[1], path.hiddenBefore);
  made.firstOnRoad = before.size();
  made.points.assign(before.rbegin(), before.rend());
  made.points.insert(made.points.end(), onRoads.begin(), onRoads.end());
  made.points.insert(made.points.end(), after.begin(), after.end());
  return made;
}

EgoRoads egoRoads(const Layout& l) {
  constexpr double kLeast = 30;  // m, least length of the main road between two turns, or before the only turn
  EgoRoads ego;
  for (const Road& road : l.roads()) {
    if (!road.joins || road.joinsLeft || laneEnd(road) < laneStart(l) + 20) continue;
    if (road.along && (ego.into == nullptr || *road.joins > *ego.into->joins)) ego.into = &road;
    if (road.against && (ego.from == nullptr || *road.joins < *ego.from->joins)) ego.from = &road;
  }
  if (ego.into != nullptr && ego.from != nullptr &&
      *ego.into->joins - *ego.from->joins < turnStart(*ego.from) + turnStart(*ego.into) + kLeast) {
    ego.from = nullptr;
  }
  // Without `from` the vehicle must not turn within kLeast of the start of the built-up part.
  if (ego.into != nullptr && ego.from == nullptr && *ego.into->joins - turnStart(*ego.into) < l.mainFrom + kLeast) {
    ego.into = nullptr;
  }
  return ego;
}

}  // namespace scanmill::town
