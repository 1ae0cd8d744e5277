// Draws the plots of a random layout with their houses, driveways and paths; in closed streets also the houses on
// corners, passages, and the buildings and courts behind the houses.

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

constexpr double kDriveway = 3;      // m, width of a driveway
constexpr double kWalkway = 1.4;     // m, width of a path to a house
constexpr double kPassage = 3.2;     // m, width of a passage between two houses of a row
constexpr double kBeforeDoor = 0.6;  // m from a door to the point in front of it where a path begins

}  // namespace

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
