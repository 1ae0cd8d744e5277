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
  Footprint about{};  // rectangle around the building; its x axis points to the road
  double gap = 1e9;   // m from the sidewalk's outer edge to the building; 1e9: no road is near
  Beside front{};     // position of the middle of the building's front relative to the nearest road

  // Returns the point at a distance (m) in front of the middle of the building's front.
  Point2 inFront(double distance) const { return about.at(about.halfX + distance, 0); }
};

// Returns the frontage of a building: its front is the side of its rectangle that is nearest to a sidewalk.
Frontage frontageOf(const Polygon& outline, const RoadNetwork& roads) {
  Frontage nearest;
  Frontage candidate{rectangleAbout(outline)};
  for (int side = 0; side < 4; ++side) {
    candidate.front = roads.at(candidate.inFront(0));
    candidate.gap = candidate.front.nearRoad ? candidate.front.edge - candidate.front.section.outer() : 1e9;
    if (side == 0 || candidate.gap < nearest.gap) nearest = candidate;
    std::swap(candidate.about.halfX, candidate.about.halfY);
    candidate.about.yaw += kPi / 2;
  }
  return nearest;
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

// True if a building has the shape of models::House: a rectangle of a house's size on the ground, with a house's roof.
bool isHouse(const MapBuilding& b, const Footprint& about) {
  constexpr models::Span kHalfWidth{2.4, 20}, kHalfDepth{2.2, 9};  // m
  return !b.shed && b.parts.empty() && b.courts.empty() && b.base <= 0 && (b.roof || !b.ridge) &&
         isRectangular(b.outline, about) && kHalfWidth.holds(about.halfY) && kHalfDepth.holds(about.halfX);
}

// True if a ridge is along the x axis of a rectangle rather than along its y axis.
bool ridgeAlong(const std::array<Point2, 2>& ridge, const Footprint& about) {
  const double x = ridge[1].x - ridge[0].x;
  const double y = ridge[1].y - ridge[0].y;
  const double c = std::cos(about.yaw);
  const double s = std::sin(about.yaw);
  return std::abs(x * c + y * s) > std::abs(y * c - x * s);
}

enum class BlockOf { Building, Part };

// Returns the block of a building or of a part of one. `middle` is the origin of its frame. `floors`: of the building;
// parts, pitched roofs and blocks that hang have the number that fits between their base and their roof.
models::Block blockOf(const MapBuilding& b, const Point2& middle, int floors, BlockOf what) {
  constexpr double kShed = 2.6, kStorey = 2.9;     // m, usual heights of sheds' and of other storeys
  constexpr double kLowest = 2.3, kParapet = 0.8;  // m, least height of a storey; of the walls above the top ceiling
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
  if (b.top && !b.shed && (what == BlockOf::Part || b.ridge || b.base > 0)) {
    const double wallHeight = block.height - b.base;
    const double usualFloors = b.floors ? *b.floors * wallHeight / block.height : wallHeight / kStorey;
    block.floors = std::max(0, static_cast<int>(std::min(std::round(usualFloors), (wallHeight - kParapet) / kLowest)));
  }
  block.shop = b.shop;
  block.outline = relativeTo(middle, b.outline);
  for (const Polygon& court : b.courts) block.courts.push_back(relativeTo(middle, court));
  return block;
}

// Returns the block of a building, or the blocks of its parts. The part on the ground that is nearest to the road has
// the door.
PlacedBlock placedBlockOf(const MapBuilding& b, const Frontage& frontage, int floors, std::uint32_t number) {
  const Point2& middle = frontage.about.center;
  PlacedBlock placed;
  placed.about = frontage.about;
  placed.entrance = frontage.inFront(0.6);
  const auto finished = [&](models::Block block) {
    block.number = number;
    block.entrance = {placed.entrance.x - middle.x, placed.entrance.y - middle.y};
    return block;
  };
  placed.block = finished(blockOf(b, middle, floors, BlockOf::Building));
  for (const MapBuilding& part : b.parts) {
    models::Block block = finished(blockOf(part, middle, floors, BlockOf::Part));
    block.parapet = block.door = false;
    placed.block.parts.push_back(std::move(block));
  }
  models::Block* nearestPart = nullptr;
  double leastDistance = 1e9;
  for (models::Block& part : placed.block.parts) {
    const double distance = distanceToRings({&part.outline}, part.entrance);
    if (part.base > 0 || distance >= leastDistance) continue;
    leastDistance = distance;
    nearestPart = &part;
  }
  if (nearestPart != nullptr) nearestPart->door = true;
  return placed;
}

// Returns the house of a building. The front of a house faces -y in its frame, and x of `frontage.about` towards the
// road.
House houseOf(const MapBuilding& b, std::uint32_t number, int floors, const Frontage& frontage, Draw& draw) {
  const Footprint& about = frontage.about;
  House house = drawHouse(draw, number, 2 * about.halfY, 2 * about.halfX, floors);
  house.shop = b.shop;
  house.relation = b.relation;
  house.top = b.top;
  if (b.roof) house.roof = *b.roof;
  if (b.riseMapped) house.rise = b.rise;
  // The ridge of a gable roof is along the front, or goes away from it.
  if (house.roof == models::Roof::Gable && b.ridge && ridgeAlong(*b.ridge, about)) {
    house.roof = models::Roof::CrossGable;
  }
  house.forecourt = std::clamp(frontage.gap, 0.0, 30.0);
  const double yaw = about.yaw + kPi / 2;
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  house.pose = models::at(
      {about.center.x - c * about.halfY + s * about.halfX, about.center.y - s * about.halfY - c * about.halfX, 0}, yaw);
  return house;
}

}  // namespace

// Turns rectangular buildings of a house's size, except sheds, into houses, and other buildings into blocks. Leaves out
// buildings on roads. Buildings that face a road, except sheds, get a plot.
void Layout::takeBuildings(const MapPlace& map) {
  constexpr double kFacing = 30;       // m; a building that is nearer to a sidewalk faces the road
  constexpr double kBeforeDoor = 0.6;  // m from a door to the point in front of it where a path begins
  int leftOut = 0;
  for (std::uint32_t number = 0; number < map.buildings.size(); ++number) {
    const MapBuilding& b = map.buildings[number];
    if (isOnRoad(b, network_)) {
      ++leftOut;
      continue;
    }
    Draw draw(seed, Kind::MapBuilding, number);
    const int randomFloors = character.floorsLow + draw.below(character.floorsHigh - character.floorsLow + 1);
    const int floors = b.usualFloors().value_or(randomFloors);
    const Frontage frontage = frontageOf(b.outline, network_);
    const Footprint& rectangle = frontage.about;
    const bool house = isHouse(b, rectangle);
    if (house) {
      houses.push_back(houseOf(b, number, floors, frontage, draw));
    } else {
      blocks.push_back(placedBlockOf(b, frontage, floors, number));
      blocks.back().block.relation = b.relation;
      for (const MapBuilding* part : lowPartsOf(b)) cover(*part, rectangle);
    }
    if (b.shed || b.base > 0 || frontage.gap > kFacing) continue;
    const Beside& front = frontage.front;
    const double setback = std::max(frontage.gap, 0.0);
    plots.push_back({.road = front.road,
                     .side = front.lateral > 0 ? 1 : -1,
                     .from = front.along - rectangle.halfY - 1,
                     .to = front.along + rectangle.halfY + 1,
                     .built = true,
                     .depth = 2 * rectangle.halfX,
                     .setback = setback});
    if (house && setback > kBeforeDoor) {
      const Vec3d door = houses.back().pose * Vec3d{houses.back().doorX(), -kBeforeDoor, 0};
      addStrip({door.x, door.y}, rectangle.yaw + kPi / 2, kPathHalf, setback - kBeforeDoor + front.section.outer(),
               GroundKind::Path);
    }
  }
  if (leftOut > 0) {
    about += fmt::format("; {} buildings that stand on a road are left out", leftOut);
    warn(fmt::format("{}: left out: {} buildings that stand on a road of the town about {:.6f}, {:.6f}",
                     parameters.map.string(), leftOut, map.origin.latitude, map.origin.longitude));
  }
  arrangePlots();
}

// Adds small squares to `covers` that together cover a building and its walls. `around`: a rectangle around it.
void Layout::cover(const MapBuilding& building, const Footprint& around) {
  constexpr double kCell = 1.6;  // m, side of the small squares
  std::vector<const Polygon*> rings{&building.outline};
  for (const Polygon& court : building.courts) rings.push_back(&court);
  for (const double v : models::steps(-around.halfY + kCell / 2, around.halfY + kCell / 2, kCell)) {
    for (const double u : models::steps(-around.halfX + kCell / 2, around.halfX + kCell / 2, kCell)) {
      const Point2 p = around.at(u, v);
      if (isInside(rings, p) || distanceToRings(rings, p) < kCell) {
        covers.push_back(models::squareAbout(p, kCell / 2, around.yaw));
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
  auto nextBuilt = built.begin();
  for (const Road& road : roads()) {
    for (const int side : {-1, 1}) {
      double end = kEnd;  // m along the road, of the last plot so far
      for (; nextBuilt != built.end() && nextBuilt->road == road.number && nextBuilt->side == side; ++nextBuilt) {
        Plot plot = *nextBuilt;
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
    return areas.outsideHard(front) < 0.5 || besideAt(front).isOnRoadOrSidewalk();
  });
  for (std::uint32_t i = 0; i < plots.size(); ++i) {
    Plot& plot = plots[i];
    plot.number = i;
    Draw draw(seed, Kind::MapFencing, i);
    plot.fencing = drawFencing(draw, plot.setback);
  }
}

}  // namespace scanmill::town
