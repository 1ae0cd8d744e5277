#include "town/lanes.h"

#include <algorithm>
#include <cmath>

#include "town/placer.h"

namespace scanmill::town {

namespace {

constexpr double kPointDistance = 6;  // m between the points of a path

// Returns points that continue a path from `beforeEnd` to `end` by `reach` m: down a ramp, in a half circle, and back
// far below the ground. Vehicles are hidden there before they arrive or after they have left.
std::vector<Vec3d> hiddenPath(const Vec3d& end, const Vec3d& beforeEnd, double reach) {
  std::vector<Vec3d> points;
  if (reach <= 0) return points;
  Vec3d ahead = end - beforeEnd;
  ahead.z = 0;
  ahead = normalized(ahead);
  const Vec3d aside{-ahead.y, ahead.x, 0};
  constexpr double kRamp = 130, kDepth = 70;  // m, horizontal length and height of the ramp down
  constexpr double kTurn = 20;                // m, radius of the half circle
  for (const double d : models::steps(10, kRamp, 10)) {
    points.push_back(end + ahead * d + Vec3d{0, 0, -kDepth * models::smooth(d / kRamp)});
  }
  const Vec3d bottom = end + ahead * kRamp + Vec3d{0, 0, -kDepth};
  for (int k = 0; k <= 6; ++k) {
    const double angle = kPi * k / 6;
    points.push_back(bottom + ahead * (kTurn * std::sin(angle)) + aside * (kTurn * (1 - std::cos(angle))));
  }
  for (const double d : models::steps(15, reach - kRamp, 40))
    points.push_back(bottom + aside * (2 * kTurn) - ahead * d);
  return points;
}

}  // namespace

LanePoints lanePoints(const Layout& l, const LanePath& path, const std::function<double(const Road&)>& lateral) {
  LanePoints result;
  std::vector<Vec3d> onRoads;
  for (const RoadInterval& s : path.intervals) {
    const Road& road = l.roads()[s.road];
    const double direction = s.to >= s.from ? 1 : -1;  // -1: against the road's line
    const auto count = std::max(1, static_cast<int>(std::abs(s.to - s.from) / kPointDistance));
    for (int k = 0; k <= count; ++k) {
      const double along = s.from + (s.to - s.from) * k / count;
      onRoads.push_back(l.onGround(besideRoad(road, along, -direction * lateral(road)).at));
      result.positions.push_back({s.road, along});
    }
  }
  const std::vector<Vec3d> after =
      hiddenPath(onRoads[onRoads.size() - 1], onRoads[onRoads.size() - 2], path.hiddenAfter);
  const std::vector<Vec3d> before = hiddenPath(onRoads[0], onRoads[1], path.hiddenBefore);
  result.firstOnRoad = before.size();
  result.points.assign(before.rbegin(), before.rend());
  result.points.insert(result.points.end(), onRoads.begin(), onRoads.end());
  result.points.insert(result.points.end(), after.begin(), after.end());
  return result;
}

EgoLine egoLine(const Layout& l) {
  Draw draw(l.seed, models::Kind::EgoLine);
  // In eleven drives of KITTI the right edge of the road was 3.25 m from the sensor (median), although most roads are
  // less than 8 m wide: people drive towards the middle of streets, and on the inner lane.
  return {.lane = draw.chance(0.6) && !l.character.plain ? 1 : 0, .towardsMiddle = draw.in(1, 1.8)};
}

LanePoints egoLanePoints(const Layout& l, const LanePath& path) {
  constexpr double kLeastLateral = 0.8;  // m, of the path from the centre line, which the vehicle may just cross
  const EgoLine line = egoLine(l);
  return lanePoints(l, path, [&](const Road& road) {
    const double rightmost = road.laneMiddle();
    if (road.oneWay() || l.character.plain) return rightmost;
    const CrossSection& s = road.section;
    return s.lanes > 1 ? rightmost - line.lane * s.laneWidth()
                       : std::min(rightmost, std::max(rightmost - line.towardsMiddle, kLeastLateral));
  });
}

// Returns, of the side roads at the right with long enough lanes, the first as `from` and the last as `into`.
EgoRoads egoRoads(const Layout& l) {
  constexpr double kLeastMain = 30;   // m, least length of the main road between two turns, or before the only turn
  constexpr double kLeastLanes = 20;  // m, least length of a side road's lanes
  EgoRoads ego;
  for (const Road& road : l.roads()) {
    if (!road.joins || road.joinsLeft || laneEnd(road) < laneStart(l) + kLeastLanes) continue;
    if (road.along && (ego.into == nullptr || *road.joins > *ego.into->joins)) ego.into = &road;
    if (road.against && (ego.from == nullptr || *road.joins < *ego.from->joins)) ego.from = &road;
  }
  if (ego.into != nullptr && ego.from != nullptr &&
      *ego.into->joins - *ego.from->joins < turnStart(*ego.from) + turnStart(*ego.into) + kLeastMain) {
    ego.from = nullptr;
  }
  // Without `from`, the route begins on the main road and must not turn in the first kLeastMain metres built up.
  if (ego.into != nullptr && ego.from == nullptr && *ego.into->joins - turnStart(*ego.into) < l.mainFrom + kLeastMain) {
    ego.into = nullptr;
  }
  return ego;
}

}  // namespace scanmill::town
