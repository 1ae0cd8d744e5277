// Draws a random layout: roads (main road, side roads, roundabout), potholes, areas (parks, parking lots, squares), and
// plots with their houses, driveways and paths.

#include <algorithm>
#include <cmath>
#include <map>

#include "town/layout.h"

namespace scanmill::town {
namespace {

using models::Fencing;
using models::Footprint;
using models::House;
using models::Kind;
using models::Roof;

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

constexpr double kDriveway = 3;      // m, width of a driveway
constexpr double kWalkway = 1.4;     // m, width of a path to a house
constexpr double kPassage = 3.2;     // m, width of a passage between two houses of a row
constexpr double kBeforeDoor = 0.6;  // m from a door to the point in front of it where a path begins

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

void Layout::setLevels() {
  constexpr double kAround = 0.5;  // m of level ground around a building
  findWaterLevels();
  for (std::uint32_t i = 0; i < patches.size(); ++i) addToCells(patches[i].rectangle, i, patchCells_);
  // Reads all heights before any terrace is set; otherwise the heights of buildings would depend on their neighbours.
  std::vector<Terrace> terraces;
  for (House& house : houses) {
    const Vec3d door = house.pose * Vec3d{house.doorX(), -kBeforeDoor, 0};
    house.pose.translation.z = heightAt({door.x, door.y});
    const double yaw = std::atan2(house.pose.linear.x.y, house.pose.linear.x.x);
    const auto addTerrace = [&](const Vec3d& middle, double width, double depth) {
      const Vec3d center = house.pose * middle;
      terraces.push_back({TurnedRectangle({{center.x, center.y}, width / 2 + kAround, depth / 2 + kAround, yaw}),
                          house.pose.translation.z});
      covers.push_back(terraces.back().rectangle);
    };
    addTerrace({house.width / 2, house.depth / 2, 0}, house.width, house.depth);
    if (house.garage) addTerrace(house.garageMiddle(), models::kGarageWidth, models::kGarageDepth);
  }
  for (PlacedBlock& b : blocks) {
    b.height = heightAt(b.entrance);
    terraces.push_back(
        {TurnedRectangle({b.about.center, b.about.halfX + kAround, b.about.halfY + kAround, b.about.yaw}), b.height});
  }
  terraces_ = std::move(terraces);
  for (std::uint32_t i = 0; i < terraces_.size(); ++i) addToCells(terraces_[i].rectangle, i, terraceCells_);
}

bool Layout::isOffRoads(const Footprint& f, double gap, double step) const {
  const std::vector<double> shares = models::steps(-1, 1.1, step);
  return std::ranges::none_of(shares, [&](double u) {
    return std::ranges::any_of(
        shares, [&](double v) { return besideAt(f.at(u * f.halfX, v * f.halfY)).isOnRoadOrSidewalk(gap); });
  });
}

// Returns a random kind of boundary between a plot and the road: None in front of houses close to the sidewalk.
Fencing Layout::drawFencing(Draw& draw, double setback) const {
  constexpr double kLeastSetback = 1.5;  // m
  const Character& c = character;
  Fencing fencing = Fencing::None;
  const double share = draw.next();
  if (share < c.hedges) {
    fencing = Fencing::Hedge;
  } else if (share < c.hedges + c.fences) {
    fencing = c.commercial ? draw.itemOf(std::array{Fencing::Wire, Fencing::Wire, Fencing::Bars})
              : c.country  ? draw.itemOf(std::array{Fencing::Pickets, Fencing::Wire, Fencing::Boards})
                           : draw.itemOf(std::array{Fencing::Pickets, Fencing::Bars, Fencing::Brick, Fencing::Brick,
                                                   Fencing::Brick, Fencing::Boards, Fencing::Boards, Fencing::Wire});
  }
  return setback < kLeastSetback ? Fencing::None : fencing;
}

void Layout::addStrip(const Point2& inner, double yaw, double half, double length, GroundKind kind) {
  const Vec3d out{std::sin(yaw), -std::cos(yaw), 0};  // towards the road
  patches.push_back(
      {TurnedRectangle({{inner.x + out.x * length / 2, inner.y + out.y * length / 2}, half, length / 2, yaw}), kind});
}

// A random house for a plot. buildOn() tests whether the house fits.
struct Layout::PlotHouse {
  House house;
  double width = 0;       // m, width of the plot's ground for the house
  double gap = 0;         // m between this house and its neighbours
  bool attached = false;  // true: wall to wall with its neighbours
  bool wanted = false, hasDriveway = false;
};

double Layout::buildingLine(const Road& road, int side) const {
  Draw draw(seed, Kind::BuildingLine, 2 * road.number + (side > 0 ? 1u : 0u));
  const double setback = character.setback + draw.in(-1, 1) * character.setbackSpread;
  return road.section.half + road.section.outer() + std::max(0.5, setback);
}

// Adds plots at both sides of all roads. In closed streets, rows end at the houses on corners.
void Layout::addAllPlots() {
  constexpr double kFirstPlot = 12;   // m along a side road, where plots begin if there is no house on the corner
  constexpr double kBehindPlots = 4;  // m, from the last plot of a side road to the road's end
  struct Mouth {
    int side;         // of the main road, on which the side road is
    double from, to;  // m along the main road, between the rows of houses
  };
  std::vector<Mouth> mouths;
  std::map<std::pair<std::uint32_t, int>, double> firstPlots;  // m along a side road, by its number and side
  for (const Road& road : roads()) {
    if (!character.terraced || !road.joins) continue;
    const int side = road.joinsLeft ? 1 : -1;
    const auto [from, firstBefore] = addCornerHouse(road, -1);
    const auto [to, firstBehind] = addCornerHouse(road, 1);
    mouths.push_back({side, from, to});
    firstPlots[{road.number, side}] = firstBefore;
    firstPlots[{road.number, -side}] = firstBehind;
  }
  std::ranges::sort(mouths, {}, &Mouth::from);
  for (const Road& road : roads()) {
    for (const int side : {-1, 1}) {
      const auto first = firstPlots.find({road.number, side});
      double from = road.main ? mainFrom : first != firstPlots.end() ? first->second : kFirstPlot;
      for (const Mouth& mouth : mouths) {
        if (!road.main || mouth.side != side) continue;
        addPlots(road, side, from, mouth.from);
        from = std::max(from, mouth.to);
      }
      addPlots(road, side, from, road.main ? mainTo : road.length() - kBehindPlots);
    }
  }
}

std::pair<double, double> Layout::addCornerHouse(const Road& road, int direction) {
  constexpr double kDepth = 13;     // m, depth of the house behind both building lines
  constexpr double kLeastCut = 3;   // m of both fronts that the cut corner takes, more where the sidewalk is rounded
  constexpr double kOverlap = 0.8;  // m by which neighbours may stand in it on the inner side of a bend
  constexpr double kCovered = 0.6;  // fraction of the depth in which nothing else is placed; a sharp corner has no more
  const Road& main = mainRoad();
  const int side = road.joinsLeft ? 1 : -1;
  const int sideOfRoad = -direction * side;
  const double mainLine = side * buildingLine(main, side);
  const double roadLine = sideOfRoad * buildingLine(road, sideOfRoad);
  // Finds the crossing of the two building lines by Newton's method.
  double onMain = *road.joins;
  double onRoad = 0;
  Point2 u;  // headings of the roads at the crossing
  Point2 v;
  for (int step = 0; step < 5; ++step) {
    const models::Spot a = besideRoad(main, onMain, mainLine);
    const models::Spot b = besideRoad(road, onRoad, roadLine);
    u = {std::cos(a.yaw), std::sin(a.yaw)};
    v = {std::cos(b.yaw), std::sin(b.yaw)};
    const double dx = b.at.x - a.at.x;
    const double dy = b.at.y - a.at.y;
    const double cross = u.x * v.y - u.y * v.x;
    onMain += (dx * v.y - dy * v.x) / cross;
    onRoad += (dx * u.y - dy * u.x) / cross;
  }
  // The outline is a kite: the two walls that touch the neighbours are kDepth long, at right angles to the roads.
  const double angle = std::acos(direction * (u.x * v.x + u.y * v.y));
  const double front = kDepth / std::tan(angle / 2);
  const auto onMainLine = [&](double along, double depth) {
    return besideRoad(main, onMain + direction * along, mainLine + side * depth);
  };
  const auto onRoadLine = [&](double along, double depth) {
    return besideRoad(road, onRoad + along, roadLine + sideOfRoad * depth);
  };
  const auto isOnRoad = [&](const Point2& p) { return besideAt(p).isOnRoadOrSidewalk(); };
  double cut = kLeastCut;
  while (cut < front - 2 && (isOnRoad(onRoadLine(cut, 0).at) || isOnRoad(onMainLine(cut, 0).at))) cut += 0.5;
  Polygon outline{onRoadLine(front, 0).at, onRoadLine(cut, 0).at, onMainLine(cut, 0).at, onMainLine(front, 0).at,
                  models::lerp(onMainLine(front, kDepth).at, onRoadLine(front, kDepth).at, 0.5)};
  const Point2 entrance = models::lerp(outline[1], outline[2], 0.5);
  const Point2 middle = models::lerp(entrance, outline[4], 0.5);
  if (direction * side < 0) std::reverse(outline.begin(), outline.begin() + 4);
  const auto strip = [&](const models::Spot& spot) {
    return Footprint{spot.at, (front - cut) / 2, kCovered * kDepth / 2, spot.yaw};
  };
  const double halfway = (front + cut) / 2;
  const Footprint strips[] = {strip(onMainLine(halfway, kCovered * kDepth / 2)),
                              strip(onRoadLine(halfway, kCovered * kDepth / 2)),
                              Footprint::square(middle, 0.3 * kDepth, std::atan2(u.y, u.x))};
  const auto isTaken = [&](const Footprint& f) { return !occupied_.isFree(f); };
  if (std::ranges::any_of(outline, isOnRoad) || std::ranges::any_of(strips, isTaken)) {
    return {onMain, std::max(onRoad, 0.0)};
  }
  for (const Footprint& f : strips) {
    occupied_.add({f.center, f.halfX - kOverlap, f.halfY, f.yaw});
    covers.push_back(f);
  }
  Draw draw(seed, Kind::CornerHouse, 2 * road.number + (direction > 0 ? 1u : 0u));
  PlacedBlock placed;
  placed.about = {middle, front / 2, kDepth / 2, std::atan2(u.y, u.x)};
  placed.entrance = entrance;
  placed.block.outline = relativeTo(middle, outline);
  placed.block.floors = character.floorsLow + draw.below(character.floorsHigh - character.floorsLow + 1);
  placed.block.rise = draw.chance(0.5) ? draw.in(2, 4) : 0;
  placed.block.openWalls = 3;
  placed.block.entrance = relativeTo(middle, {entrance}).front();
  placed.block.shop = draw.chance(0.6);
  placed.block.number = static_cast<std::uint32_t>(blocks.size());
  blocks.push_back(std::move(placed));
  return {onMain + direction * front, onRoad + front};
}

// Adds the plots at one side of a road, from `from` to `to` (m along the road). Each plot has one random stream, whose
// order must not change: the plot, its house, its fence, whether it is built, its driveway, ground in front, garage.
void Layout::addPlots(const Road& road, int side, double from, double to) {
  constexpr double kLeastPlot = 8;   // m; a shorter interval at the end of a road gets no plot
  constexpr double kIntoPlot = 6;    // m from the plot's front to the point at which areas are tested
  constexpr double kPassages = 0.1;  // fraction of attached houses with a passage beside them
  constexpr double kPassageDepth = 6.5, kPassageHeight = 3;  // m, of the building above a passage, and below it
  const double setback = buildingLine(road, side) - road.section.half - road.section.outer();
  double start = from;
  while (to - start > kLeastPlot) {
    const auto number = static_cast<std::uint32_t>(plots.size());
    Draw draw(seed, Kind::Plot, number);
    const bool inRow = start > from && !plots.empty() && plots.back().built && plots.back().to == start;
    const bool passage = character.terraced && draw.chance(kPassages) && inRow;
    if (passage) start += kPassage;
    Plot plot{.number = number, .road = road.number, .side = side, .from = start};
    plot.to = std::min(to, start + draw.around(character.plotWidth, 0.3));
    if (character.terraced && to - plot.to < kLeastPlot) plot.to = to;
    plot.setback = character.terraced ? setback + draw.in(-0.15, 0.15)
                                      : std::max(1.0, character.setback + draw.in(-1, 1) * character.setbackSpread);
    PlotHouse plotHouse = drawPlotHouse(draw, road, plot);
    plot.depth = plotHouse.house.depth;
    plot.fencing = drawFencing(draw, plot.setback);
    constexpr double kLeastWidth = 6.5, kTight = 0.5;  // m, least house width; m by which a driveway may exceed the gap
    plotHouse.wanted = draw.chance(character.built) && plotHouse.width >= kLeastWidth;
    plotHouse.hasDriveway = !plotHouse.attached && draw.chance(0.6) && plotHouse.gap > kDriveway - kTight;
    plot.built = buildOn(plot, road, plotHouse, draw);
    if (passage && plot.built) {
      const models::Spot middle = inPlot(plot, start - kPassage / 2, plot.setback + 0.5 + kPassageDepth / 2);
      addPlainBuilding({middle.at, kPassage / 2 + 0.1, kPassageDepth / 2, middle.yaw + (side > 0 ? 0 : kPi)},
                       2.9 * houses.back().floors, 0);
      blocks.back().block.base = kPassageHeight;
    }
    if (character.terraced && !plot.built) plot.fencing = Fencing::Brick;  // a wall closes the gap
    start = plot.to;
    // Plots without a house become gardens, but are left out if they are on an area, such as a park or parking lot.
    const double middle = (plot.from + plot.to) / 2;
    if (!plot.built && areas.landAt(inPlot(plot, middle, kIntoPlot).at)) continue;
    plots.push_back(plot);
  }
}

// Returns the random house of a plot. In bends, a plot's width differs between front and back. Attached houses are as
// wide as the front of the plot; other houses fit into the plot at the front and at the back.
Layout::PlotHouse Layout::drawPlotHouse(Draw& draw, const Road& road, const Plot& plot) const {
  const Character& c = character;
  const bool halls = c.commercial;
  PlotHouse result;
  result.attached = c.terraced && draw.chance(0.95);
  const double depth = halls ? draw.in(12, 22) : draw.in(7.5, 12.5);
  const Point2 heading = road.heading((plot.from + plot.to) / 2);
  const auto widthAt = [&](double lateral) {
    const Point2 a = besideRoad(road, plot.from, plot.side * lateral).at;
    const Point2 b = besideRoad(road, plot.to, plot.side * lateral).at;
    return (b.x - a.x) * heading.x + (b.y - a.y) * heading.y;
  };
  const double front = road.section.half + road.section.outer() + plot.setback;
  result.width = result.attached ? widthAt(front) : std::min(widthAt(front), widthAt(front + depth));
  result.gap = result.attached ? 0 : draw.in(1.2, std::max(1.5, 0.35 * result.width));
  const int floors = c.floorsLow + draw.below(c.floorsHigh - c.floorsLow + 1);
  const double widest = halls ? 32 : result.attached ? 24 : 18;  // m
  result.house = drawHouse(draw, plot.number, std::clamp(result.width - result.gap, 6.0, widest), depth, floors);
  if (halls) result.house.roof = Roof::Flat;
  if (result.attached && result.house.roof != Roof::Flat) result.house.roof = Roof::Gable;
  result.house.shop = c.terraced && draw.chance(0.4);
  return result;
}

// Adds a plot's house, driveway and garage. Adds nothing and returns false if no house is wanted or it does not fit.
bool Layout::buildOn(const Plot& plot, const Road& road, const PlotHouse& plotHouse, Draw& draw) {
  House house = plotHouse.house;
  // The left and the right end of the building line, seen from the road.
  const Point2 left = inPlot(plot, plot.side > 0 ? plot.from : plot.to, plot.setback).at;
  const Point2 right = inPlot(plot, plot.side > 0 ? plot.to : plot.from, plot.setback).at;
  const double yaw = std::atan2(right.y - left.y, right.x - left.x);
  // If the plot has a driveway, which is at its right end, the house is shifted to the left.
  const Point2 center = Footprint{models::lerp(left, right, 0.5), 0, 0, yaw}.at(
      plotHouse.hasDriveway ? 0.2 - plotHouse.gap / 2 : 0, house.depth / 2);
  const Footprint body{center, house.width / 2, house.depth / 2, yaw};
  constexpr double kApart = 0.4;  // m, half of the least distance between two houses
  // On the inner side of a bend, attached houses may overlap at the back.
  const double overlap = std::max(0.8, 0.08 * house.width);  // m, half of the largest overlap
  const Footprint free{center, body.halfX + (plotHouse.attached ? -overlap : kApart), body.halfY + kApart, yaw};
  if (!plotHouse.wanted || !isOffRoads(body, 0.0) || !occupied_.isFree(free)) return false;
  occupied_.add({center, body.halfX - (plotHouse.attached ? overlap : 0), body.halfY, yaw});
  house.forecourt = plot.setback;
  house.ivy = draw.chance(0.2 * parameters.greenery);
  // In the house's frame, the front wall is at y = 0 and faces -y; seen from the road, x points to the right.
  const Point2 corner = body.at(-body.halfX, -body.halfY);
  house.pose = models::at({corner.x, corner.y, 0}, yaw);
  addGroundInFront(house, yaw, plotHouse.width, road.section.outer(), draw);
  if (plotHouse.hasDriveway) house.garage = addDriveway(house, yaw, road.section.outer(), draw);
  if (plotHouse.attached && !houses.empty()) {
    constexpr double kTouching = kPassage + 0.3;  // m, distance up to which walls are hidden or in a passage
    House& leftHouse = plot.side > 0 ? houses.back() : house;
    House& rightHouse = plot.side > 0 ? house : houses.back();
    const Vec3d end = leftHouse.pose * Vec3d{leftHouse.width, 0, 0};
    if (length(end - rightHouse.pose.translation) < kTouching) leftHouse.partyRight = rightHouse.partyLeft = true;
  }
  houses.push_back(house);
  return true;
}

// Adds rows of plain buildings behind a plot of a closed street, each behind a court, so that gaps do not show open
// land. Instead of a building there may be garages. More than half of the courts are paved; the others are gardens.
void Layout::addRearBuildings(const Plot& plot) {
  if (!character.terraced) return;
  constexpr int kRows = 3;
  constexpr double kOverlap = 0.8, kWidest = 24;              // m; see buildOn() and drawPlotHouse()
  constexpr double kStorey = 3, kGap = 0.1, kLeastWidth = 4;  // m
  constexpr double kGarage = 3, kGarageDepth = 5.5;           // m
  Draw draw(seed, Kind::RearBuildings, plot.number);
  const double middle = (plot.from + plot.to) / 2;
  const double width = std::min(plot.to - plot.from, kWidest);
  const double front = plot.setback + plot.depth;
  const auto rowAt = [&](double depth, double size) {
    const models::Spot spot = inPlot(plot, middle, depth + size / 2);
    return Footprint{spot.at, std::max(width / 2 - kGap, kLeastWidth / 2), size / 2,
                     spot.yaw + (plot.side > 0 ? 0 : kPi)};
  };
  double behind = front;  // m behind the front of the plot
  for (int row = 0; row < kRows; ++row) {
    const double court = draw.in(5, 10), depth = draw.in(7, 12);
    const double height = kStorey * (1 + draw.below(character.floorsHigh));
    const double rise = draw.chance(0.6) ? depth * draw.in(0.2, 0.4) : 0;
    const bool open = draw.chance(0.2);
    const Footprint rear = rowAt(behind + court, depth);
    const Footprint free{rear.center, rear.halfX - kOverlap, rear.halfY, rear.yaw};
    if (!isOffRoads(rear, 1.5) || !occupied_.isFree(free)) break;
    behind += court + depth;
    if (!open) {
      occupied_.add(free);
      addPlainBuilding(rear, height, rise);
    } else if (draw.chance(0.7)) {
      Footprint garages = rowAt(behind - depth / 2, kGarageDepth);
      garages.halfX = kGarage / 2 * std::floor(2 * garages.halfX / kGarage);
      addPlainBuilding(garages, draw.in(2.3, 2.7), 0);
    }
  }
  if (behind == front || draw.chance(0.4)) return;
  patches.push_back({TurnedRectangle(rowAt(front, behind - front)), GroundKind::Paved});
}

void Layout::addPlainBuilding(const Footprint& walls, double height, double rise) {
  covers.push_back(walls);
  PlacedBlock placed;
  placed.about = walls;
  placed.entrance = walls.at(0, -walls.halfY);
  placed.block.outline = relativeTo(walls.center, cornersOf(walls));
  placed.block.rise = rise;
  placed.block.ridge = {relativeTo(walls.center, {walls.at(-walls.halfX, 0)}).front(),
                        relativeTo(walls.center, {walls.at(walls.halfX, 0)}).front()};
  placed.block.floors = 0;
  placed.block.height = height;
  placed.block.door = false;
  placed.block.number = static_cast<std::uint32_t>(blocks.size());
  blocks.push_back(std::move(placed));
}

// Adds a paved forecourt, or a path to the road. `width`: width of the plot; `outer`: distance to the carriageway (m).
void Layout::addGroundInFront(const House& house, double yaw, double width, double outer, Draw& draw) {
  constexpr double kUnder = 0.4;   // m, overlap of the forecourt with the house
  constexpr double kParkable = 6;  // m, least depth of a forecourt on which cars park
  if (!character.terraced && draw.chance(character.forecourts)) {
    const Vec3d front = house.pose * Vec3d{house.width / 2, kUnder, 0};
    // A third of the forecourts are as wide as the plot.
    const double half = draw.chance(1.0 / 3) ? width / 2 : house.width / 2 + draw.in(0.3, 2);
    addStrip({front.x, front.y}, yaw, half, house.forecourt + kUnder + outer, GroundKind::Path);
    patches.back().parks = house.forecourt > kParkable && draw.chance(0.95);
  } else if (house.forecourt > kBeforeDoor) {
    const Vec3d door = house.pose * Vec3d{house.doorX(), -kBeforeDoor, 0};
    addStrip({door.x, door.y}, yaw, kWalkway / 2, house.forecourt - kBeforeDoor + outer, GroundKind::Path);
  }
}

// Adds a driveway at the right of the house. Returns true if the house gets a garage at the driveway's end.
bool Layout::addDriveway(const House& house, double yaw, double outer, Draw& draw) {
  constexpr double kBeside = 0.3, kBehindFront = 6;  // m from the house's side; from its front to the driveway's end
  const Vec3d end = house.pose * Vec3d{house.width + kDriveway / 2 + kBeside, kBehindFront, 0};
  addStrip({end.x, end.y}, yaw, kDriveway / 2, house.forecourt + kBehindFront + outer, GroundKind::Driveway);
  patches.back().parks = true;
  const Vec3d inside = house.pose * house.garageMiddle();
  const Footprint garage{{inside.x, inside.y}, models::kGarageWidth / 2 - 0.05, models::kGarageDepth / 2, yaw};
  const bool built = draw.chance(0.55) && isOffRoads(garage, 1) && occupied_.isFree(garage);
  if (built) occupied_.add(garage);
  return built;
}

}  // namespace scanmill::town
