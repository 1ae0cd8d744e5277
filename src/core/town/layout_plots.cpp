// Adds plots along the roads, with their houses, driveways and paths.

#include <algorithm>
#include <cmath>

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
constexpr double kBeforeDoor = 0.6;  // m from a door to the point in front of it where a path begins

}  // namespace

void Layout::setLevels() {
  constexpr double kAround = 0.5;  // m of level ground around a building
  findWaterLevels();
  for (std::uint32_t i = 0; i < patches.size(); ++i) addToCells(patches[i].rectangle, i, patchCells_);
  // Reads all heights before any terrace is set. Otherwise buildings that are close together would lift each other.
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

// Returns the fence, hedge or wall of a plot at the road; there is none in front of houses close to the sidewalk.
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

// A random house for a plot. buildOn() finds out whether it has room.
struct Layout::PlotHouse {
  House house;
  double width = 0;       // m, width of the ground that the plot has for the house
  double gap = 0;         // m between this house and its neighbours
  bool attached = false;  // true: wall to wall with its neighbours
  bool wanted = false, hasDriveway = false;
};

// Adds the plots at one side of a road, between two distances along it (m). The random stream of a plot draws in the
// order of the calls: the plot, its house, its fence, whether it is built, its driveway, ground in front, garage.
void Layout::addPlots(const Road& road, int side, double from, double to) {
  constexpr double kLeastPlot = 8;  // m; a shorter rest at the end of a road gets no plot
  constexpr double kIntoPlot = 6;   // m from the sidewalk to the point whose area decides about a plot
  double start = from;
  while (to - start > kLeastPlot) {
    const auto number = static_cast<std::uint32_t>(plots.size());
    Draw draw(seed, Kind::Plot, number);
    Plot plot{.number = number, .road = road.number, .side = side, .from = start};
    plot.to = std::min(to, start + draw.around(character.plotWidth, 0.3));
    plot.setback =
        std::max(character.terraced ? 0.35 : 1.0, character.setback + draw.in(-1, 1) * character.setbackSpread);
    PlotHouse plotHouse = drawPlotHouse(draw, road, plot);
    plot.depth = plotHouse.house.depth;
    plot.fencing = drawFencing(draw, plot.setback);
    constexpr double kLeastWidth = 6.5, kTight = 0.5;  // m, of a house's ground; that a driveway may lack beside it
    plotHouse.wanted = draw.chance(character.built) && plotHouse.width >= kLeastWidth;
    plotHouse.hasDriveway = !plotHouse.attached && draw.chance(0.6) && plotHouse.gap > kDriveway - kTight;
    plot.built = buildOn(plot, road, plotHouse, draw);
    start = plot.to;
    // Plots without a house become gardens, but are left out in areas (park, wood, parking lot, water ...).
    const double middle = (plot.from + plot.to) / 2;
    if (!plot.built && areas.landAt(inPlot(plot, middle, kIntoPlot).at)) continue;
    plots.push_back(plot);
  }
}

// Returns the random house of a plot. A bend makes a plot wider or narrower than the road's line beside it. Attached
// houses are as wide as their plots at the front; the others fit between their neighbours at the back, too.
Layout::PlotHouse Layout::drawPlotHouse(Draw& draw, const Road& road, const Plot& plot) const {
  const Character& c = character;
  const bool halls = c.commercial;
  PlotHouse result;
  result.attached = c.terraced && draw.chance(0.75);
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
  result.house.shop = c.terraced && draw.chance(0.4);
  return result;
}

// Builds a house on its plot, with driveway and garage. Returns false if no house is wanted or there is no room.
bool Layout::buildOn(const Plot& plot, const Road& road, const PlotHouse& plotHouse, Draw& draw) {
  House house = plotHouse.house;
  // The ends of the plot's front, from left to right as seen from the road.
  const Point2 left = inPlot(plot, plot.side > 0 ? plot.from : plot.to, plot.setback).at;
  const Point2 right = inPlot(plot, plot.side > 0 ? plot.to : plot.from, plot.setback).at;
  const double yaw = std::atan2(right.y - left.y, right.x - left.x);
  // If there is a driveway at the right end of the plot, the house is shifted towards the left end.
  const Point2 center = Footprint{models::lerp(left, right, 0.5), 0, 0, yaw}.at(
      plotHouse.hasDriveway ? 0.2 - plotHouse.gap / 2 : 0, house.depth / 2);
  const Footprint body{center, house.width / 2, house.depth / 2, yaw};
  constexpr double kApart = 0.4;  // m, half of the least distance between two houses
  // On the inner side of a bend the backs of attached houses overlap.
  constexpr double kOverlap = 0.8;  // m, half of the largest overlap
  const Footprint free{center, body.halfX + (plotHouse.attached ? -kOverlap : kApart), body.halfY + kApart, yaw};
  if (!plotHouse.wanted || !isOffRoads(body, 0.0) || !occupied_.isFree(free)) return false;
  occupied_.add({center, body.halfX - (plotHouse.attached ? kOverlap : 0), body.halfY, yaw});
  house.forecourt = plot.setback;
  house.ivy = draw.chance(0.2 * parameters.greenery);
  // In the house's frame, the front wall is in y = 0 and faces -y; x points to the right as seen from the road.
  const Point2 corner = body.at(-body.halfX, -body.halfY);
  house.pose = models::at({corner.x, corner.y, 0}, yaw);
  addGroundInFront(house, yaw, plotHouse.width, road.section.outer(), draw);
  if (plotHouse.hasDriveway) house.garage = addDriveway(house, yaw, road.section.outer(), draw);
  houses.push_back(house);
  return true;
}

// Adds a paved forecourt or a path to the road. `width`: of the house's ground; `outer`: from plot to carriageway (m).
void Layout::addGroundInFront(const House& house, double yaw, double width, double outer, Draw& draw) {
  constexpr double kUnder = 0.4;   // m that a forecourt reaches under the house
  constexpr double kParkable = 7;  // m, least depth of a forecourt on which cars park
  if (!character.terraced && draw.chance(character.forecourts)) {
    const Vec3d front = house.pose * Vec3d{house.width / 2, kUnder, 0};
    // A third of the forecourts are as wide as the plot.
    const double half = draw.chance(1.0 / 3) ? width / 2 : house.width / 2 + draw.in(0.3, 2);
    addStrip({front.x, front.y}, yaw, half, house.forecourt + kUnder + outer, GroundKind::Path);
    patches.back().parks = house.forecourt > kParkable && draw.chance(0.8);
  } else if (house.forecourt > kBeforeDoor) {
    const Vec3d door = house.pose * Vec3d{house.doorX(), -kBeforeDoor, 0};
    addStrip({door.x, door.y}, yaw, kWalkway / 2, house.forecourt - kBeforeDoor + outer, GroundKind::Path);
  }
}

// Adds a driveway at the right of the house. Returns true if there is a garage at its end.
bool Layout::addDriveway(const House& house, double yaw, double outer, Draw& draw) {
  constexpr double kBeside = 0.3, kBehindFront = 6;  // m from the house, and from its front to the driveway's end
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
