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

constexpr double kDriveway = 3;   // m, width of a driveway
constexpr double kWalkway = 1.4;  // m, width of a path to a house

}  // namespace

void Layout::drawPlots() {
  for (const Road& road : roads()) {
    for (const int side : {-1, 1}) {
      addPlots(road, side, road.main ? mainFrom : 12, road.main ? mainTo : road.length() - 4);
    }
  }
}

void Layout::settle() {
  findWaterLevels();
  for (std::uint32_t i = 0; i < patches.size(); ++i) enter(patches[i].place, i, patchCells_);
  // Reads all heights before any terrace is set. Otherwise buildings that are close together would lift each other.
  std::vector<Terrace> terraces;
  for (models::House& house : houses) {
    const Vec3d door = house.place * Vec3d{house.doorX(), -0.6, 0};
    house.place.translation.z = heightAt({door.x, door.y});
    const double yaw = std::atan2(house.place.linear.x.y, house.place.linear.x.x);
    const auto level = [&](const Vec3d& middle, double width, double depth) {
      const Vec3d at = house.place * middle;
      terraces.push_back(
          {TurnedRectangle({{at.x, at.y}, width / 2 + 0.5, depth / 2 + 0.5, yaw}), house.place.translation.z});
      covers.push_back(terraces.back().place);
    };
    level({house.width / 2, house.depth / 2, 0}, house.width, house.depth);
    if (house.garage) level(house.garageMiddle(), models::kGarageWidth, models::kGarageDepth);
  }
  for (PlacedBlock& b : blocks) {
    b.height = heightAt(b.entrance);
    terraces.push_back(
        {TurnedRectangle({b.about.center, b.about.halfX + 0.5, b.about.halfY + 0.5, b.about.yaw}), b.height});
  }
  terraces_ = std::move(terraces);
  for (std::uint32_t i = 0; i < terraces_.size(); ++i) enter(terraces_[i].place, i, terraceCells_);
}

// True if the rectangle's middle, corners and middles of sides are at least `gap` metres from roads and sidewalks.
bool Layout::isOffRoads(const Footprint& f, double gap) const {
  for (const double u : {-1.0, 0.0, 1.0}) {
    for (const double v : {-1.0, 0.0, 1.0}) {
      const Point2 at = f.at(u * f.halfX, v * f.halfY);
      const Beside beside = besideAt(at);
      if (beside.known && beside.edge < beside.section.outer() + gap) return false;
    }
  }
  return true;
}

Fencing Layout::drawFencing(Draw& draw, double setback) const {
  const Character& c = character;
  Fencing fencing = Fencing::None;
  const double pick = draw.next();
  if (pick < c.hedges) {
    fencing = Fencing::Hedge;
  } else if (pick < c.hedges + c.fences) {
    fencing = c.district == District::Commercial ? draw.of(std::array{Fencing::Wire, Fencing::Wire, Fencing::Bars})
              : c.country                        ? draw.of(std::array{Fencing::Pickets, Fencing::Wire, Fencing::Boards})
                          : draw.of(std::array{Fencing::Pickets, Fencing::Bars, Fencing::Brick, Fencing::Brick,
                                               Fencing::Brick, Fencing::Boards, Fencing::Boards, Fencing::Wire});
  }
  return setback < 1.5 ? Fencing::None : fencing;
}

void Layout::addStrip(const Point2& inner, double yaw, double half, double length, GroundKind kind) {
  const Vec3d out{std::sin(yaw), -std::cos(yaw), 0};  // towards the road
  patches.push_back(
      {TurnedRectangle({{inner.x + out.x * length / 2, inner.y + out.y * length / 2}, half, length / 2, yaw}), kind});
}

void Layout::addPlots(const Road& road, int side, double from, double to) {
  const Character& c = character;
  const bool dense = c.terraced;
  const bool halls = c.district == District::Commercial;
  double start = from;
  while (to - start > 8) {
    Plot plot;
    plot.number = static_cast<std::uint32_t>(plots.size());
    Draw draw(seed, Kind::Plot, plot.number);
    plot.road = road.number;
    plot.side = side;
    plot.from = start;
    plot.to = std::min(to, start + draw.around(c.plotWidth, 0.3));
    plot.setback = std::max(dense ? 0.35 : 1.0, c.setback + draw.in(-1, 1) * c.setbackSpread);
    const bool attached = dense && draw.chance(0.75);
    const double depth = halls ? draw.in(12, 22) : draw.in(7.5, 12.5);
    const double middle = (plot.from + plot.to) / 2;
    const double outer = road.section.half + road.section.outer();
    const Point2 heading = road.heading(middle);
    const auto spot = [&](double along, double lateral) { return besideRoad(road, along, side * lateral).at; };
    // A bend makes a plot wider or narrower than the road's line beside it. Attached houses are as wide as their plots
    // at the front; the others fit between their neighbours at the back, too.
    const auto widthAt = [&](double lateral) {
      const Point2 a = spot(plot.from, lateral);
      const Point2 b = spot(plot.to, lateral);
      return (b.x - a.x) * heading.x + (b.y - a.y) * heading.y;
    };
    const double frontWidth = widthAt(outer + plot.setback);
    const double width = attached ? frontWidth : std::min(frontWidth, widthAt(outer + plot.setback + depth));
    const double gap = attached ? 0 : draw.in(1.2, std::max(1.5, 0.35 * width));
    const int floors = c.floorsLow + draw.below(c.floorsHigh - c.floorsLow + 1);
    House house = drawHouse(draw, plot.number,
                            std::clamp(width - gap, 6.0,
                                       halls      ? 32.0
                                       : attached ? 24.0
                                                  : 18.0),
                            depth, floors);
    if (halls) house.roof = Roof::Flat;
    house.shop = dense && draw.chance(0.4);
    plot.depth = depth;
    plot.fencing = drawFencing(draw, plot.setback);
    const bool wanted = draw.chance(c.built) && width >= 6.5;
    const bool hasDriveway = !attached && draw.chance(0.6) && gap > kDriveway - 0.5;
    // The ends of the plot's front, from left to right as seen from the road.
    const Point2 left = spot(side > 0 ? plot.from : plot.to, outer + plot.setback);
    const Point2 right = spot(side > 0 ? plot.to : plot.from, outer + plot.setback);
    const double yaw = std::atan2(right.y - left.y, right.x - left.x);
    // If there is a driveway at the right end of the plot, the house is shifted towards the left end.
    const Point2 center =
        Footprint{models::lerp(left, right, 0.5), 0, 0, yaw}.at(hasDriveway ? 0.2 - gap / 2 : 0, house.depth / 2);
    const Footprint body{center, house.width / 2, house.depth / 2, yaw};
    // On the inner side of a bend the backs of attached houses overlap.
    constexpr double kOverlap = 0.8;  // m, half of the largest overlap
    const double shared = attached ? kOverlap : 0;
    const Footprint roomy{center, body.halfX + (attached ? -kOverlap : 0.4), body.halfY + 0.4, yaw};
    if (wanted && isOffRoads(body, 0.0) && taken_.isFree(roomy)) {
      taken_.add({center, body.halfX - shared, body.halfY, yaw});
      plot.built = true;
      house.forecourt = plot.setback;
      house.ivy = draw.chance(0.2 * parameters.greenery);
      // Sets the house's frame: the front wall is in the plane y = 0 and faces -y; x points to the right as seen from
      // the road.
      const Point2 corner = body.at(-body.halfX, -body.halfY);
      house.place = models::at({corner.x, corner.y, 0}, yaw);
      const Vec3d door = house.place * Vec3d{house.doorX(), -0.6, 0};
      const double out = road.section.outer();
      if (!dense && draw.chance(c.forecourts)) {
        const Vec3d front = house.place * Vec3d{house.width / 2, 0.4, 0};
        // A third of the forecourts are as wide as the plot.
        const double half = draw.chance(1.0 / 3) ? width / 2 : house.width / 2 + draw.in(0.3, 2);
        addStrip({front.x, front.y}, yaw, half, plot.setback + 0.4 + out, GroundKind::Path);
        patches.back().parks = plot.setback > 7 && draw.chance(0.8);
      } else if (plot.setback > 0.6) {
        addStrip({door.x, door.y}, yaw, kWalkway / 2, plot.setback - 0.6 + out, GroundKind::Path);
      }
      if (hasDriveway) {
        const Vec3d beside = house.place * Vec3d{house.width + kDriveway / 2 + 0.3, 6, 0};
        addStrip({beside.x, beside.y}, yaw, kDriveway / 2, plot.setback + 6 + out, GroundKind::Driveway);
        patches.back().parks = true;
        const Vec3d inside = house.place * house.garageMiddle();
        const Footprint garage{{inside.x, inside.y}, models::kGarageWidth / 2 - 0.05, models::kGarageDepth / 2, yaw};
        house.garage = draw.chance(0.55) && isOffRoads(garage, 1) && taken_.isFree(garage);
        if (house.garage) taken_.add(garage);
      }
      houses.push_back(house);
    }
    start = plot.to;
    // Leaves out a plot without a house if it is in an area (park, wood, parking lot, water ...). Elsewhere such a plot
    // becomes a garden.
    if (!plot.built && areas.at(spot(middle, outer + 6))) continue;
    plots.push_back(plot);
  }
}

}  // namespace scanmill::town
