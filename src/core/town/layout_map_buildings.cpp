// Adds the buildings of a map and their plots.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "town/layout.h"
#include "town/map.h"

namespace scanmill::town {
namespace {

using models::Footprint;
using models::House;
using models::Kind;

// The position of a building relative to the nearest road.
struct Frontage {
  Footprint about;   // rectangle around the building; its x axis points to the road
  double gap = 1e9;  // m from the sidewalk's outer edge to the building; 1e9: no road is near
  Beside before;     // position of the middle of the building's front relative to the nearest road

  Point2 inFront(double distance) const { return about.at(about.halfX + distance, 0); }
};

Frontage frontageOf(const Polygon& outline, const RoadNetwork& roads) {
  Frontage best;
  Frontage turned;
  turned.about = rectangleAbout(outline);
  for (int side = 0; side < 4; ++side) {
    const Point2 front = turned.inFront(0);
    turned.before = roads.at(front);
    turned.gap = turned.before.nearRoad ? turned.before.edge - turned.before.section.outer() : 1e9;
    if (side == 0 || turned.gap < best.gap) best = turned;
    std::swap(turned.about.halfX, turned.about.halfY);
    turned.about.yaw += kPi / 2;
  }
  return best;
}

// Returns the building or, if it has parts, its parts; without those under which a road may pass.
std::vector<const MapBuilding*> lowPartsOf(const MapBuilding& b) {
  constexpr double kClear = 4;  // m, height of the lowest part over a road
  std::vector<const MapBuilding*> low;
  for (const MapBuilding& part : b.parts) {
    if (part.base < kClear) low.push_back(&part);
  }
  if (b.parts.empty() && b.base < kClear) low.push_back(&b);
  return low;
}

// True if the building is on a carriageway: a road may pass through it, or the map may be wrong.
bool isOnRoad(const MapBuilding& b, const RoadNetwork& roads) {
  constexpr double kSlip = 0.3;  // m that a building may extend onto a carriageway
  for (const MapBuilding* part : lowPartsOf(b)) {
    for (const Point2& p : pointsAlong(part->outline, 1)) {
      const Beside beside = roads.at(p);
      if (beside.nearRoad && beside.edge < -kSlip) return true;
    }
  }
  return false;
}

bool isHouse(const MapBuilding& b, const Footprint& about) {
  const bool rectangular = isRectangular(b.outline, about) && b.courts.empty();
  const bool plain = b.parts.empty() && b.base <= 0 && (b.roof || !b.ridge);
  return plain && rectangular && !b.shed && about.halfY > 2.4 && about.halfY < 20 && about.halfX > 2.2 &&
         about.halfX < 9;
}

// True if a ridge is along the x axis of a rectangle rather than along its y axis.
bool ridgeAlong(const std::array<Point2, 2>& ridge, const Footprint& about) {
  const double x = ridge[1].x - ridge[0].x;
  const double y = ridge[1].y - ridge[0].y;
  const double c = std::cos(about.yaw);
  const double s = std::sin(about.yaw);
  return std::abs(x * c + y * s) > std::abs(y * c - x * s);
}

// Returns the block of a building or, if `part` is true, of a part of one. `middle` is the origin of its frame.
models::Block blockOf(const MapBuilding& b, const Point2& middle, int floors, bool part) {
  constexpr double kShed = 2.6, kStorey = 2.9, kLowest = 2.3;  // m, usual heights of storeys, and the least height
  models::Block block;
  block.floors = b.shed ? 0 : floors;
  block.height = b.shed ? b.top.value_or(kShed * b.floors.value_or(1)) : b.top.value_or(0);
  block.base = b.base;
  if (b.ridge) {
    const std::vector<Point2> ridge = relativeTo(middle, {b.ridge->front(), b.ridge->back()});
    block.ridge = {ridge.front(), ridge.back()};
    block.height = b.eaves().value_or(b.shed ? block.height : 0);
    block.rise = b.top ? *b.top - block.height : b.rise;
  }
  if (b.top && !b.shed && (part || b.ridge || b.base > 0)) {
    // The floors between the base and the roof.
    const double walls = block.height - b.base;
    const double above = b.floors ? *b.floors * walls / block.height : walls / kStorey;
    block.floors = std::max(0, static_cast<int>(std::min(std::round(above), (walls - 0.8) / kLowest)));
  }
  block.shop = b.shop;
  block.outline = relativeTo(middle, b.outline);
  for (const Polygon& court : b.courts) block.courts.push_back(relativeTo(middle, court));
  return block;
}

// Returns the block of a building, or the blocks of its parts.
PlacedBlock placedBlockOf(const MapBuilding& b, const Frontage& frontage, int floors, std::uint32_t number) {
  const Point2& middle = frontage.about.center;
  PlacedBlock placed;
  placed.about = frontage.about;
  placed.entrance = frontage.inFront(0.6);
  const auto finish = [&](models::Block block) {
    block.number = number;
    block.entrance = {placed.entrance.x - middle.x, placed.entrance.y - middle.y};
    return block;
  };
  placed.block = finish(blockOf(b, middle, floors, false));
  models::Block* front = nullptr;  // the part with the door
  double least = 1e9;
  for (const MapBuilding& part : b.parts) {
    models::Block block = finish(blockOf(part, middle, floors, true));
    block.parapet = block.door = false;
    placed.block.parts.push_back(std::move(block));
  }
  for (models::Block& part : placed.block.parts) {
    const double distance = distanceToRings({&part.outline}, part.entrance);
    if (part.base > 0 || distance >= least) continue;
    least = distance;
    front = &part;
  }
  if (front != nullptr) front->door = true;
  return placed;
}

// Returns the house of a building. `yaw`: of the house, whose front faces -y in its own frame.
House houseOf(const MapBuilding& b, std::uint32_t number, int floors, const Frontage& frontage, double yaw,
              Draw& draw) {
  const Footprint& around = frontage.about;
  House house = drawHouse(draw, number, 2 * around.halfY, 2 * around.halfX, floors);
  house.shop = b.shop;
  house.relation = b.relation;
  house.top = b.top;
  if (b.roof) house.roof = *b.roof;
  if (b.riseSaid) house.rise = b.rise;
  // The ridge of a gable roof is along the front, or goes away from it.
  if (house.roof == models::Roof::Gable && b.ridge && ridgeAlong(*b.ridge, around)) {
    house.roof = models::Roof::CrossGable;
  }
  house.forecourt = std::clamp(frontage.gap, 0.0, 30.0);
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  house.pose = models::at(
      {around.center.x - c * around.halfY + s * around.halfX, around.center.y - s * around.halfY - c * around.halfX, 0},
      yaw);
  return house;
}

}  // namespace

// Turns rectangular buildings of a house's size, except sheds, into houses, and other buildings into blocks. Leaves out
// buildings on roads. Buildings that face a road, except sheds, get a plot.
void Layout::takeBuildings(const MapPlace& map) {
  int onRoads = 0;
  for (std::uint32_t number = 0; number < map.buildings.size(); ++number) {
    const MapBuilding& b = map.buildings[number];
    if (isOnRoad(b, network_)) {
      ++onRoads;
      continue;
    }
    Draw draw(seed, Kind::MapBuilding, number);
    const int drawn = character.floorsLow + draw.below(character.floorsHigh - character.floorsLow + 1);
    const int floors = b.floorsSaid().value_or(drawn);
    const Frontage frontage = frontageOf(b.outline, network_);
    const Footprint& around = frontage.about;
    const double yaw = around.yaw + kPi / 2;  // of a house
    const bool house = isHouse(b, around);
    if (house) {
      houses.push_back(houseOf(b, number, floors, frontage, yaw, draw));
    } else {
      blocks.push_back(placedBlockOf(b, frontage, floors, number));
      blocks.back().block.relation = b.relation;
      for (const MapBuilding* part : lowPartsOf(b)) cover(*part, around);
    }
    constexpr double kFacing = 30;  // m; a building that is nearer to a sidewalk faces the road
    if (b.shed || b.base > 0 || frontage.gap > kFacing) continue;
    const Beside& before = frontage.before;
    Plot plot;
    plot.road = before.road;
    plot.side = before.lateral > 0 ? 1 : -1;
    plot.from = before.along - around.halfY - 1;
    plot.to = before.along + around.halfY + 1;
    plot.setback = std::max(frontage.gap, 0.0);
    plot.depth = 2 * around.halfX;
    plot.built = true;
    plots.push_back(plot);
    if (house && plot.setback > 0.6) {
      const Vec3d door = houses.back().pose * Vec3d{houses.back().doorX(), -0.6, 0};
      addStrip({door.x, door.y}, yaw, kPathHalf, plot.setback - 0.6 + before.section.outer(), GroundKind::Path);
    }
  }
  if (onRoads > 0) {
    about += fmt::format("; {} buildings that stand on a road are left out", onRoads);
    warn(fmt::format("{}: left out: {} buildings that stand on a road of the town about {:.6f}, {:.6f}",
                     parameters.map.string(), onRoads, map.origin.latitude, map.origin.longitude));
  }
  arrangePlots();
}

// Adds small rectangles to covers that together cover a building and its walls.
void Layout::cover(const MapBuilding& building, const Footprint& around) {
  constexpr double kCell = 1.6;  // m, side of the small rectangles
  std::vector<const Polygon*> rings{&building.outline};
  for (const Polygon& court : building.courts) rings.push_back(&court);
  for (const double v : models::steps(-around.halfY + kCell / 2, around.halfY + kCell / 2, kCell)) {
    for (const double u : models::steps(-around.halfX + kCell / 2, around.halfX + kCell / 2, kCell)) {
      const Point2 p = around.at(u, v);
      if (isInside(rings, p) || distanceToRings(rings, p) < kCell) {
        covers.push_back({p, kCell / 2, kCell / 2, around.yaw});
      }
    }
  }
}

// Adds bare plots at one side of a road, between two distances along it (m). Returns the end of the last one, or
// `from`.
double Layout::addBarePlots(const Road& road, int side, double from, double to) {
  constexpr double kLeastPlot = 8;  // m; less ground gets no plot
  while (to - from > kLeastPlot) {
    Plot plot{.road = road.number, .side = side, .from = from, .bare = true};
    Draw draw(seed, Kind::BarePlot, plots.size());
    plot.to = std::min(to, from + draw.around(character.plotWidth, 0.3));
    plot.setback = character.setback;
    from = plot.to;
    plots.push_back(plot);
  }
  return from;
}

// Sorts the plots along the roads, removes overlaps, and adds bare plots where there are no buildings. Removes plots
// whose front is on a parking lot, a square, water or another road; the others then get their numbers and fences.
void Layout::arrangePlots() {
  constexpr double kEnd = 4;  // m at the ends of a road without bare plots
  std::stable_sort(plots.begin(), plots.end(), [](const Plot& a, const Plot& b) {
    return std::tie(a.road, a.side, a.from) < std::tie(b.road, b.side, b.from);
  });
  std::vector<Plot> built = std::move(plots);
  plots.clear();
  auto next = built.begin();
  for (const Road& road : roads()) {
    for (const int side : {-1, 1}) {
      double end = kEnd;  // m along the road, of the last plot so far
      for (; next != built.end() && next->road == road.number && next->side == side; ++next) {
        Plot plot = *next;
        plot.to = std::min(plot.to, road.length() - 2);
        plot.from = std::max(plot.from, end);
        if (plot.to - plot.from < 2) continue;  // the plot is behind another plot
        plot.from = addBarePlots(road, side, end, plot.from);
        end = plot.to;
        plots.push_back(plot);
      }
      addBarePlots(road, side, end, road.length() - kEnd);
    }
  }
  std::erase_if(plots, [&](const Plot& plot) {
    const Point2 front = inPlot(plot, (plot.from + plot.to) / 2, 1.5).at;
    const Beside b = besideAt(front);
    return areas.outsideHard(front) < 0.5 || (b.nearRoad && b.edge < b.section.outer());
  });
  for (std::uint32_t i = 0; i < plots.size(); ++i) {
    Plot& plot = plots[i];
    plot.number = i;
    Draw draw(seed, Kind::MapFencing, i);
    plot.fencing = drawFencing(draw, plot.setback);
  }
}

}  // namespace scanmill::town
