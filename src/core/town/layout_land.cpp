// Draws a random layout's roads (the main road, side roads, roundabouts at the end of side roads), the potholes in all
// roads, and land beside the roads that is neither garden nor wood: parks, parking lots, squares.

#include <algorithm>
#include <cmath>

#include "town/layout.h"

namespace scanmill::town {
namespace {

using models::Footprint;
using models::Kind;

// Returns the point at a distance (m) from another one, in the direction `angle` (rad).
Point2 polar(const Point2& from, double distance, double angle) {
  return {from.x + distance * std::cos(angle), from.y + distance * std::sin(angle)};
}

// Returns a roundabout that begins at the angle `start` (rad) as seen from its centre.
Road ringRoad(const Point2& center, double radius, double start, CrossSection section) {
  Road ring;
  const auto count = static_cast<int>(std::ceil(2 * kPi * radius / kRoadStep));
  for (int k = 0; k <= count; ++k) ring.line.push_back(polar(center, radius, start + 2 * kPi * k / count));
  section.parking = section.sidewalk = 0;
  section.half = 3;
  section.verge = 1;
  section.curb = 0.15;
  section.step = std::max(section.step, 0.08);
  ring.section = section;
  ring.against = false;
  ring.ring = true;
  return ring;
}

// Returns the points of a random line. Its heading is a smooth random field that varies by less than a right angle, so
// that the line never crosses itself. `bend`: amplitude of the heading (rad).
std::vector<Point2> drawLine(const FieldAddress& field, const Point2& from, double heading, double bend,
                             double length) {
  constexpr double kBends = 90;    // m, size of bends
  constexpr double kToUnit = 1.8;  // factor on the field, so that its largest values are about 1
  std::vector<Point2> points{from};
  const double start = relief(field, 0, 0.5, kBends);
  for (double s = 0; s + kRoadStep / 2 < length; s += kRoadStep) {
    const double turned = heading + bend * kToUnit * (relief(field, s + kRoadStep / 2, 0.5, kBends) - start);
    points.push_back(polar(points.back(), kRoadStep, turned));
  }
  return points;
}

}  // namespace

// Adds land beside a road, beyond the sidewalk. `width` and `depth`: size of the land along and across the road (m).
// Returns false if another road or other land is in the way.
bool Layout::addLand(Land land, const Road& road, int side, double along, double width, double depth) {
  constexpr double kFromSidewalk = 1.5;  // m between the sidewalk and the land
  constexpr double kIntoLand = 1;        // m of an entrance within the land
  const models::Spot middle =
      besideRoad(road, along, side * (road.section.half + road.section.outer() + kFromSidewalk + depth / 2));
  const double yaw = middle.yaw + (side > 0 ? 0 : kPi);
  const Footprint place{middle.at, width / 2, depth / 2, yaw};
  for (const double u : models::steps(-1, 1.1, 0.25)) {
    for (const double v : models::steps(-1, 1.1, 0.25)) {
      const Point2 at = place.at(u * place.halfX, v * place.halfY);
      const Beside beside = besideAt(at);
      if (beside.nearRoad && beside.edge < beside.section.outer()) return false;
    }
  }
  if (!taken_.isFree({place.center, place.halfX + 2, place.halfY + 2, yaw})) return false;
  taken_.add(place);
  areas.add({land, cornersOf(place), {}});
  // Adds the entrance of a parking lot.
  const double front = depth / 2 - kIntoLand;
  const Point2 inner{place.center.x + std::sin(yaw) * front, place.center.y - std::cos(yaw) * front};
  constexpr double kLotEntrance = 3;  // m, half of the width
  const double length = kFromSidewalk + 1.5 + road.section.outer();
  if (land == Land::Lot) addStrip(inner, yaw, kLotEntrance, length, GroundKind::Driveway);
  if (land != Land::Park) return true;
  // Adds the entrance of a park and two paths that cross in it.
  addStrip(inner, yaw, kPathHalf, length, GroundKind::Path);
  patches.push_back({TurnedRectangle({place.center, kPathHalf, place.halfY - 1, yaw}), GroundKind::Path});
  patches.push_back({TurnedRectangle({place.center, place.halfX - 1, kPathHalf, yaw}), GroundKind::Path});
  return true;
}

// Tries to add parking lots, a park and a square at random positions beside the roads.
void Layout::drawLand() {
  if (character.country) return;
  struct Wish {
    Land land;
    double chance;
    double widthLow, widthHigh, depthLow, depthHigh;  // m
  };
  const double lots = character.commercial ? 1.0 : 0.6;
  const Wish wishes[] = {{Land::Lot, character.commercial ? 1.0 : 0.0, 40, 80, 30, 45},
                         {Land::Park, 0.5, 40, 80, 30, 60},
                         {Land::Lot, lots, 28, 60, 17.5, 40},
                         {Land::Paved, character.terraced ? 0.5 : 0.2, 22, 40, 16, 30}};
  std::uint32_t number = 0;
  for (const Wish& wish : wishes) {
    Draw draw(seed, Kind::Land, number++);
    if (!draw.chance(wish.chance)) continue;
    constexpr int kTries = 12;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const bool onMain = draw.chance(0.6);
      const auto sides = static_cast<int>(roads().size()) - 1;
      const Road& road = roads()[static_cast<std::size_t>(onMain || sides == 0 ? 0 : 1 + draw.below(sides))];
      const double low = road.main ? mainFrom + 20 : 30;
      const double high = road.main ? mainTo - 20 : road.length() - 20;
      const double along = draw.in(low, std::max(low, high));
      const double width = draw.in(wish.widthLow, wish.widthHigh);
      const double depth = draw.in(wish.depthLow, wish.depthHigh);
      if (addLand(wish.land, road, draw.chance(0.5) ? 1 : -1, along, width, depth)) break;
    }
  }
}

// True if no road but the one with the number `except` is within `reach` metres of a point.
bool Layout::isClear(const Point2& p, double reach, std::uint32_t except) const {
  for (std::uint32_t k = 0; k < 16; ++k) {
    const Beside b = besideAt(polar(p, reach, kPi * k / 8));
    if (b.nearRoad && b.edge < b.section.outer() && b.road != except) return false;
  }
  return true;
}

// Adds a roundabout at the end of a random side road, as in many suburbs: a ring with an island, and up to three roads
// that leave the ring.
void Layout::drawRoundabout() {
  constexpr double kRingFromEdge = 70, kRoadFromEdge = 30;  // m, least distances from the edge of the ground
  Draw draw(seed, Kind::Roundabout);
  if (character.country || roads().size() < 2 || !draw.chance(0.35)) return;
  const auto pick = static_cast<std::uint32_t>(1 + draw.below(static_cast<int>(roads().size()) - 1));
  const Road from = roads()[pick];
  const Point2 end = from.line.back();
  const Point2 heading = from.heading(from.length());
  const double radius = draw.in(11, 16);
  const Point2 center{end.x + radius * heading.x, end.y + radius * heading.y};
  const auto isInside = [&](const Point2& p, double fromEdge) {
    return std::max(std::abs(p.x), std::abs(p.y)) <= halfSide - fromEdge;
  };
  if (!isInside(center, kRingFromEdge) || !isClear(center, radius + 12, pick)) return;
  network_.add(ringRoad(center, radius, std::atan2(end.y - center.y, end.x - center.x), from.section));
  network_.addJoint(end);
  for (const double turn : {draw.in(-2, -0.8), draw.in(-0.4, 0.4), draw.in(0.8, 2)}) {
    const double angle = std::atan2(heading.y, heading.x) + turn;
    const double length = draw.in(35, 80);
    const Point2 begin = polar(center, radius, angle);
    if (draw.chance(0.3) || !isInside(polar(begin, length, angle), kRoadFromEdge)) continue;
    if (!std::ranges::all_of(models::steps(25, length, 5),
                             [&](double d) { return isClear(polar(begin, d, angle), 9, pick); })) {
      continue;
    }
    Road exit;
    for (const double d : models::steps(0, length, kRoadStep)) exit.line.push_back(polar(begin, d, angle));
    exit.section = from.section;
    network_.add(std::move(exit));
    network_.addJoint(begin);
  }
}

// Adds the main road, whose middle is the origin, and then the side roads.
void Layout::drawRoads() {
  const double reach = parameters.length / 2 + kBeyond;
  Road main;
  main.line = drawLine({seed, Field::MainRoadBehind}, {0, 0}, kPi, character.bend, reach);
  std::reverse(main.line.begin(), main.line.end());
  const std::vector<Point2> ahead = drawLine({seed, Field::MainRoadAhead}, {0, 0}, 0, character.bend, reach);
  main.line.insert(main.line.end(), ahead.begin() + 1, ahead.end());
  main.section = character.main;
  main.main = true;
  network_.add(std::move(main));
  const double middle = mainRoad().length() / 2;
  mainFrom = middle - parameters.length / 2;
  mainTo = middle + parameters.length / 2;
  drawSideRoads();
}

// Adds the side roads, which begin at the main road; some continue on its other side. Two side roads at the same side
// are far enough apart for plots.
void Layout::drawSideRoads() {
  constexpr double kApart = 45, kApartOpposite = 14;  // m, least distances between two side roads
  std::vector<std::pair<double, int>> taken;          // distances along the main road (m), and sides
  for (int i = 0; i < character.sideRoads; ++i) {
    Draw draw(seed, Kind::SideRoad, i);
    const double along = draw.in(mainFrom + 20, mainTo - 20);
    const double angle = kPi / 2 + draw.in(-0.45, 0.45);
    const bool crosses = draw.chance(0.5);
    const int first = draw.chance(0.5) ? 1 : -1;
    for (const int side : {first, -first}) {
      if (side != first && !crosses) continue;
      const bool near = std::any_of(taken.begin(), taken.end(), [&](const auto& t) {
        return std::abs(t.first - along) < (t.second == side ? kApart : kApartOpposite);
      });
      if (near && side == first) break;
      if (near) continue;
      const Point2 at = mainRoad().point(along);
      const Point2 heading = mainRoad().heading(along);
      Road road;
      const double turn = std::atan2(heading.y, heading.x) + (side == first ? side * angle : side * (kPi - angle));
      const FieldAddress field{seed, Field::SideRoad, static_cast<std::uint32_t>(2 * i + (side > 0 ? 1 : 0))};
      road.line = drawLine(field, at, turn, 0.6 * character.bend, draw.in(60, 150));
      road.section = character.side;
      road.joins = along;
      road.joinsLeft = side > 0;
      network_.add(std::move(road));
      network_.addJoint(at);
      taken.emplace_back(along, side);
    }
  }
}

void Layout::drawPotholes() {
  for (const Road& road : roads()) {
    Draw draw(seed, Kind::Pothole, road.number);
    const auto count = static_cast<int>(12 * character.wear * road.length() / 100 + draw.next());
    for (int k = 0; k < count; ++k) {
      const double along = draw.in(0, road.length());
      const double reach = road.section.half - road.section.parking - 0.7;
      const double lateral = draw.in(-reach, reach);
      potholes.push_back({besideRoad(road, along, lateral).at, draw.in(0.2, 0.6), draw.in(0.02, 0.07)});
    }
  }
  for (std::uint32_t i = 0; i < potholes.size(); ++i) {
    enter({potholes[i].center, potholes[i].radius, potholes[i].radius, 0}, i, potholeCells_);
  }
}

}  // namespace scanmill::town
