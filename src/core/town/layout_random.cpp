// Draws the roads of a random layout (main road, side roads, roundabout), their potholes, and areas beside them (parks,
// parking lots, squares).

#include <algorithm>
#include <cmath>

#include "town/layout.h"

namespace scanmill::town {
namespace {

using models::Footprint;
using models::Kind;

// Returns the point `distance` metres from `from` in the direction `angle` (rad).
Point2 polar(const Point2& from, double distance, double angle) {
  return {from.x + distance * std::cos(angle), from.y + distance * std::sin(angle)};
}

// Returns a roundabout's ring, counter-clockwise from the angle `start` (rad). `section`: section of the joining roads.
Road ringRoad(const Point2& center, double radius, double start, CrossSection section) {
  section.parking = section.sidewalk = 0;
  section.half = 3;
  section.verge = 1;
  section.curb = 0.15;
  section.step = std::max(section.step, 0.08);
  Road ring{.section = section, .ring = true, .against = false};
  const auto count = static_cast<int>(std::ceil(2 * kPi * radius / kRoadStep));
  for (int k = 0; k <= count; ++k) ring.line.push_back(polar(center, radius, start + 2 * kPi * k / count));
  return ring;
}

// Returns points, kRoadStep apart, of a random line that begins at `from` with `heading` (rad). The heading varies with
// a random field of amplitude `bend` (rad), by less than a right angle, so that the line never crosses itself.
std::vector<Point2> drawLine(const FieldAddress& field, const Point2& from, double heading, double bend,
                             double length) {
  constexpr double kBends = 90;    // m, size of bends
  constexpr double kToUnit = 1.8;  // factor on the field: its largest values become about 1
  const auto fieldAt = [&](double along) { return relief(field, along, 0.5, kBends); };
  std::vector<Point2> points{from};
  for (double along = 0; along + kRoadStep / 2 < length; along += kRoadStep) {
    const double change = bend * kToUnit * (fieldAt(along + kRoadStep / 2) - fieldAt(0));
    points.push_back(polar(points.back(), kRoadStep, heading + change));
  }
  return points;
}

}  // namespace

// Adds an area and its entrances, kFromSidewalk beyond a road's sidewalk. `along`: position of the area's middle;
// `width`, `depth`: sizes along and across the road (m). Adds nothing and returns false if something is in the way.
bool Layout::tryAddLand(Land land, const Road& road, int side, double along, double width, double depth) {
  constexpr double kFromSidewalk = 1.5;  // m
  constexpr double kApart = 2;           // m, least distance from houses and other areas
  const models::Spot middle =
      besideRoad(road, along, side * (road.section.half + road.section.outer() + kFromSidewalk + depth / 2));
  const double yaw = middle.yaw + (side > 0 ? 0 : kPi);
  const Footprint area{middle.at, width / 2, depth / 2, yaw};
  if (!isOffRoads(area, 0, 0.25)) return false;
  if (!occupied_.isFree({area.center, area.halfX + kApart, area.halfY + kApart, yaw})) return false;
  occupied_.add(area);
  areas.add({land, cornersOf(area), {}});
  constexpr double kOverlap = 1.5;  // m, length of the entrance inside the area and on the road together
  addEntrances(land, area, kFromSidewalk + kOverlap + road.section.outer());
  return true;
}

// Adds the entrance of a parking lot or park and, in a park, two paths that cross in the middle. `area`: its -y axis
// points to the road; `length`: length of the entrance (m), which begins kIntoLand inside the area.
void Layout::addEntrances(Land land, const Footprint& area, double length) {
  constexpr double kIntoLand = 1;         // m
  constexpr double kHalfLotEntrance = 3;  // m, half of the entrance's width
  const Point2 inner = area.at(0, kIntoLand - area.halfY);
  if (land == Land::Lot) addStrip(inner, area.yaw, kHalfLotEntrance, length, GroundKind::Driveway);
  if (land != Land::Park) return;
  addStrip(inner, area.yaw, kPathHalf, length, GroundKind::Path);
  patches.push_back({TurnedRectangle({area.center, kPathHalf, area.halfY - 1, area.yaw}), GroundKind::Path});
  patches.push_back({TurnedRectangle({area.center, area.halfX - 1, kPathHalf, area.yaw}), GroundKind::Path});
}

// Tries to add parking lots, a park and a square at random positions beside the roads.
void Layout::drawLand() {
  if (character.country) return;
  struct LandKind {
    Land land;
    double chance;
    double widthLow, widthHigh, depthLow, depthHigh;  // m
  };
  const bool commercial = character.commercial;
  const LandKind kinds[] = {{Land::Lot, commercial ? 1.0 : 0.0, 40, 80, 30, 45},
                            {Land::Park, 0.5, 40, 80, 30, 60},
                            {Land::Lot, commercial ? 1.0 : 0.6, 28, 60, 17.5, 40},
                            {Land::Paved, character.terraced ? 0.5 : 0.2, 22, 40, 16, 30}};
  std::uint32_t number = 0;
  for (const LandKind& kind : kinds) {
    Draw draw(seed, Kind::Land, number++);
    if (!draw.chance(kind.chance)) continue;
    constexpr int kTries = 12;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const bool onMain = draw.chance(0.6);
      const auto sideRoads = static_cast<int>(roads().size()) - 1;
      const Road& road = roads()[static_cast<std::size_t>(onMain || sideRoads == 0 ? 0 : 1 + draw.below(sideRoads))];
      const double low = road.main ? mainFrom + 20 : 30;  // m along the road
      const double high = road.main ? mainTo - 20 : road.length() - 20;
      const double along = draw.in(low, std::max(low, high));
      const double width = draw.in(kind.widthLow, kind.widthHigh);
      const double depth = draw.in(kind.depthLow, kind.depthHigh);
      if (tryAddLand(kind.land, road, draw.chance(0.5) ? 1 : -1, along, width, depth)) break;
    }
  }
}

// True if none of 16 points on a circle of radius `reach` (m) about `p` is on a sidewalk or a road except `exceptRoad`.
bool Layout::isClear(const Point2& p, double reach, std::uint32_t exceptRoad) const {
  for (std::uint32_t k = 0; k < 16; ++k) {
    const Beside b = besideAt(polar(p, reach, kPi * k / 8));
    if (b.isOnRoadOrSidewalk() && b.road != exceptRoad) return false;
  }
  return true;
}

// In some towns, adds a roundabout at the end of a random side road: a ring, and up to three roads that leave the ring.
void Layout::drawRoundabout() {
  constexpr double kRingFromEdge = 70, kRoadFromEdge = 30;   // m, least distances from the edge of the ground
  constexpr double kRingClearance = 12, kExitClearance = 9;  // m, least distances from other roads
  constexpr double kExitBegin = 25;  // m along an exit, from where on other roads count; the ring is nearer
  Draw draw(seed, Kind::Roundabout);
  if (character.country || roads().size() < 2 || !draw.chance(0.35)) return;
  const auto sideRoadNumber = static_cast<std::uint32_t>(1 + draw.below(static_cast<int>(roads().size()) - 1));
  const Road sideRoad = roads()[sideRoadNumber];
  const Point2 end = sideRoad.line.back();
  const Point2 heading = sideRoad.heading(sideRoad.length());
  const double radius = draw.in(11, 16);
  const Point2 center{end.x + radius * heading.x, end.y + radius * heading.y};
  const auto isInside = [&](const Point2& p, double fromEdge) {
    return std::max(std::abs(p.x), std::abs(p.y)) <= halfSide - fromEdge;
  };
  if (!isInside(center, kRingFromEdge) || !isClear(center, radius + kRingClearance, sideRoadNumber)) return;
  network_.add(ringRoad(center, radius, std::atan2(end.y - center.y, end.x - center.x), sideRoad.section));
  network_.addJoint(end);
  for (const double deflection : {draw.in(-2, -0.8), draw.in(-0.4, 0.4), draw.in(0.8, 2)}) {  // rad
    const double angle = std::atan2(heading.y, heading.x) + deflection;
    const double length = draw.in(35, 80);
    const Point2 begin = polar(center, radius, angle);
    if (draw.chance(0.3) || !isInside(polar(begin, length, angle), kRoadFromEdge)) continue;
    const auto isClearAt = [&](double d) { return isClear(polar(begin, d, angle), kExitClearance, sideRoadNumber); };
    if (!std::ranges::all_of(models::steps(kExitBegin, length, 5), isClearAt)) continue;
    Road exit{.section = sideRoad.section};
    for (const double d : models::steps(0, length, kRoadStep)) exit.line.push_back(polar(begin, d, angle));
    network_.add(std::move(exit));
    network_.addJoint(begin);
  }
}

// Adds the main road, whose middle is the town's origin, and the side roads.
void Layout::drawRoads() {
  const double reach = parameters.length / 2 + kBeyond;
  Road main{.section = character.main, .main = true};
  main.line = drawLine({seed, Field::MainRoadBehind}, {0, 0}, kPi, character.bend, reach);
  std::reverse(main.line.begin(), main.line.end());
  const std::vector<Point2> ahead = drawLine({seed, Field::MainRoadAhead}, {0, 0}, 0, character.bend, reach);
  main.line.insert(main.line.end(), ahead.begin() + 1, ahead.end());
  network_.add(std::move(main));
  const double middle = mainRoad().length() / 2;
  mainFrom = middle - parameters.length / 2;
  mainTo = middle + parameters.length / 2;
  drawSideRoads();
}

// Adds side roads, which begin at the main road, far enough apart for plots. Some cross the main road.
void Layout::drawSideRoads() {
  constexpr double kApart = 45, kApartOpposite = 14;  // m, between roads at the same side and at opposite sides
  struct Junction {
    double along;  // m along the main road
    int side;
  };
  std::vector<Junction> junctions;
  for (int i = 0; i < character.sideRoads; ++i) {
    Draw draw(seed, Kind::SideRoad, i);
    const double along = draw.in(mainFrom + 20, mainTo - 20);
    const double angle = kPi / 2 + draw.in(-0.45, 0.45);
    const bool crosses = draw.chance(0.5);
    const int firstSide = draw.chance(0.5) ? 1 : -1;
    for (const int side : {firstSide, -firstSide}) {
      if (side != firstSide && !crosses) continue;
      const bool tooNear = std::ranges::any_of(junctions, [&](const Junction& j) {
        return std::abs(j.along - along) < (j.side == side ? kApart : kApartOpposite);
      });
      if (tooNear && side == firstSide) break;
      if (tooNear) continue;
      const Point2 start = mainRoad().point(along);
      const Point2 mainHeading = mainRoad().heading(along);
      const double heading =
          std::atan2(mainHeading.y, mainHeading.x) + (side == firstSide ? side * angle : side * (kPi - angle));
      const FieldAddress field{seed, Field::SideRoad, static_cast<std::uint32_t>(2 * i + (side > 0 ? 1 : 0))};
      network_.add({.line = drawLine(field, start, heading, 0.6 * character.bend, draw.in(60, 150)),
                    .section = character.side,
                    .joins = along,
                    .joinsLeft = side > 0});
      network_.addJoint(start);
      junctions.push_back({along, side});
    }
  }
}

// Adds potholes to the lanes of all roads, in proportion to the wear of the roads.
void Layout::drawPotholes() {
  for (const Road& road : roads()) {
    Draw draw(seed, Kind::Pothole, road.number);
    constexpr double kMostPer100m = 12;
    const auto count = static_cast<int>(kMostPer100m * character.wear * road.length() / 100 + draw.next());
    for (int k = 0; k < count; ++k) {
      const double along = draw.in(0, road.length());
      const double reach = road.section.half - road.section.parking - 0.7;
      const double lateral = draw.in(-reach, reach);
      potholes.push_back({besideRoad(road, along, lateral).at, draw.in(0.2, 0.6), draw.in(0.02, 0.07)});
    }
  }
  for (std::uint32_t i = 0; i < potholes.size(); ++i) {
    addToCells(Footprint::square(potholes[i].center, potholes[i].radius), i, potholeCells_);
  }
}

}  // namespace scanmill::town
