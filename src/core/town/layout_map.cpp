// Lays out a town from a map: takes roads, land and buildings from the map, and adds plots.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "config/text.h"
#include "town/layout.h"
#include "town/map.h"

namespace scanmill::town {
namespace {

using models::Footprint;
using models::House;
using models::Kind;

constexpr double kOnRoad = 1.6;  // m; a building closer to a road's centre line counts as on the road

// Returns `parameters`; the map's district replaces the value "any" of the key `district`.
Parameters inDistrict(Parameters parameters, const std::string& district) {
  if (parameters.district == "any") parameters.district = district;
  return parameters;
}

// Returns the cross section of a road on the map. A width that the map lacks is the usual width for the road's class
// or, for residential roads, random. Service roads, tracks and roundabouts have neither sidewalks nor parking lanes.
CrossSection sectionOf(const MapRoad& road, const Character& c, Draw draw) {
  constexpr double kWidths[] = {7.5, 7, 6.4, 0, 3.8, 2.7};  // m, by RoadClass, estimates; 0: not used
  constexpr double kRingWidth = 6.5, kOneWayShare = 0.65;   // m, width of a roundabout; fraction of a two-way road
  const bool minor = road.kind >= RoadClass::Service;
  double width = road.kind == RoadClass::Residential ? 2 * c.main.laneWidth() * draw.in(0.85, 1.05)
                                                     : kWidths[static_cast<std::size_t>(road.kind)];
  if (road.oneWay && !minor) width = road.ring ? kRingWidth : kOneWayShare * width;
  CrossSection s = minor ? CrossSection{} : c.main;
  s.lanes = 1;
  s.shoulder = s.median = 0;
  const bool parked = draw.chance(0.4);
  const double bay = draw.in(1.9, 2.3);
  s.parking = minor || road.ring || !road.parking.value_or(parked && c.main.parking > 0) ? 0 : bay;
  s.half = road.width.value_or(width) / 2 + s.parking;
  if (minor || road.ring) {
    s.sidewalk = 0;
    s.verge = road.ring ? 1 : 0;
  } else if (road.sidewalk) {
    s.sidewalk = *road.sidewalk ? std::max(s.sidewalk, 1.5) : 0;
  }
  s.curb = s.sidewalk > 0 || road.ring ? 0.15 : 0;
  s.step = s.curb > 0 ? std::max(s.step, 0.1) : 0;
  return s;
}

// Narrows a cross section to fit between walls, but not below its least widths: first the verge, then the sidewalk, the
// parking lane and the lanes. The fraction kIgnored of the walls may remain on the carriageway, the fraction
// kOnPavement on the pavement. `walls`: distances (m) from the centre line to points on the walls, in any order.
void narrowBetweenWalls(CrossSection& s, std::vector<double> walls) {
  constexpr double kGap = 0.4;            // m, least distance between the carriageway and a wall that is not ignored
  constexpr double kLeastHalf = 1.6;      // m, half of the width of the narrowest road
  constexpr double kLeastSidewalk = 0.6;  // m
  constexpr double kOnPavement = 0.15;    // fraction of the walls that may be on the pavement
  constexpr double kIgnored = 0.02;       // fraction of the walls that may be on the carriageway
  if (walls.empty()) return;
  std::sort(walls.begin(), walls.end());
  const auto quantile = [&](double share) {
    return walls[static_cast<std::size_t>(share * static_cast<double>(walls.size() - 1))];
  };
  const double nearest = quantile(kIgnored);
  const auto excess = [&] { return s.half + s.outer() - quantile(kOnPavement); };
  s.verge -= std::clamp(excess(), 0.0, s.verge);
  if (s.sidewalk > kLeastSidewalk) s.sidewalk -= std::clamp(excess(), 0.0, s.sidewalk - kLeastSidewalk);
  if (s.half + kGap > nearest && s.parking > 0) {
    s.half -= s.parking;
    s.parking = 0;
  }
  s.half = std::max(kLeastHalf, std::min(s.half, nearest - kGap));
}

// The position of a building relative to the nearest road.
struct Frontage {
  Footprint about{};  // rectangle around the building; its x axis points to the road
  double gap = 1e9;   // m from the sidewalk's outer edge to the building; 1e9 if no road is near
  Beside front{};     // the middle of the building's front relative to the nearest road

  // Returns the point at a distance (m) in front of the middle of the building's front.
  Point2 inFront(double distance) const { return about.at(about.halfX + distance, 0); }
};

// Returns the frontage of a building. The front is the side of the building's rectangle that is nearest to a sidewalk.
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

// Returns the parts of a building, or the building if it has no parts. Leaves out parts under which a road can pass.
std::vector<const MapBuilding*> lowPartsOf(const MapBuilding& b) {
  constexpr double kClear = 4;  // m, least height of a part above a road
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

// True if models::House can represent the building: a rectangle on the ground, of a house's size, with a house's roof.
bool isHouse(const MapBuilding& b, const Footprint& about) {
  constexpr models::Span kHalfWidth{2.4, 20}, kHalfDepth{2.2, 9};  // m
  return !b.shed && b.parts.empty() && b.courts.empty() && b.base <= 0 && (b.roof || !b.ridge) &&
         isRectangular(b.outline, about) && kHalfWidth.holds(about.halfY) && kHalfDepth.holds(about.halfX);
}

// True if the ridge is closer in direction to the rectangle's x axis than to its y axis.
bool ridgeAlong(const std::array<Point2, 2>& ridge, const Footprint& about) {
  const double x = ridge[1].x - ridge[0].x;
  const double y = ridge[1].y - ridge[0].y;
  const double c = std::cos(about.yaw);
  const double s = std::sin(about.yaw);
  return std::abs(x * c + y * s) > std::abs(y * c - x * s);
}

enum class BlockOf { Building, Part };

// Returns the block of a building or of a building's part. `middle`: origin of the block's frame. `floors`: number of
// floors of the building. Parts, and blocks with a ridge or a base, get the number that fits if the top is known.
models::Block blockOf(const MapBuilding& b, const Point2& middle, int floors, BlockOf what) {
  constexpr double kShed = 2.6, kStorey = 2.9;     // m, usual heights of a shed's storey and of other storeys
  constexpr double kLowest = 2.3, kParapet = 0.8;  // m, least height of a storey; height of walls above the top ceiling
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

// Returns the block of a building, with the blocks of its parts. The part nearest to the entrance has the door.
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

// Returns the house of a building. The house's -y axis becomes the +x axis of `frontage.about`, towards the road.
House houseOf(const MapBuilding& b, std::uint32_t number, int floors, const Frontage& frontage, Draw& draw) {
  const Footprint& about = frontage.about;
  House house = drawHouse(draw, number, 2 * about.halfY, 2 * about.halfX, floors);
  house.shop = b.shop;
  house.relation = b.relation;
  house.top = b.top;
  if (b.roof) house.roof = *b.roof;
  if (b.riseMapped) house.rise = b.rise;
  // A cross gable's ridge is perpendicular to the front, like the x axis of `about`.
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

Layout::Layout(const Parameters& keys, std::uint64_t townSeed, const MapPlace& map)
    : parameters(inDistrict(keys, map.district)),
      seed(townSeed),
      character(parameters, townSeed),
      barriers(map.barriers),
      trees(map.trees),
      halfSide(reachOf(keys)) {
  const std::string& road = map.roads.front().name;
  about = fmt::format("{}; {} at {:.6f}, {:.6f}", character.inWords(),
                      road.empty() ? "a road without a name" : quotedForMessage(road), map.origin.latitude,
                      map.origin.longitude);
  takeRoads(map);
  drawPotholes();
  for (const MapArea& area : map.areas) {
    areas.add(area);
    if (area.land != Land::Wood) continue;
    const auto isFarFromRoads = [&](const Point2& p) {
      return std::max(std::abs(p.x), std::abs(p.y)) <= halfSide && !besideAt(p).nearRoad;
    };
    if (std::ranges::any_of(pointsAlong(area.outline, 10), isFarFromRoads)) {
      warn("{}: woods farther than {} m from every road have no trees", parameters.map.string(), RoadNetwork::kReach);
    }
  }
  takeBuildings(map);
  for (const MapPath& path : map.paths) {
    constexpr double kOverlap = 0.2;  // m, by which each segment is extended at both ends
    const double half = path.width ? *path.width / 2 : kPathHalf;
    for (std::size_t i = 1; i < path.line.size(); ++i) {
      const Point2& a = path.line[i - 1];
      const Point2& b = path.line[i];
      const Footprint segment{
          {(a.x + b.x) / 2, (a.y + b.y) / 2}, distance(a, b) / 2 + kOverlap, half, std::atan2(b.y - a.y, b.x - a.x)};
      patches.push_back({TurnedRectangle(segment), GroundKind::Path});
    }
  }
  setLevels();
}

void Layout::findWaterLevels() {
  constexpr double kBelow = 0.3;  // m, height of the lowest point of the shore above the water
  for (const MapArea& area : areas.list()) {
    double level = 0;
    if (area.land == Land::Water) {
      level = 1e9;
      for (const Point2& p : pointsAlong(area.outline, 4)) {
        level = std::min(level, heightAt(GroundKind::Lawn, besideAt(p), p) - kBelow);
      }
    }
    waterLevels_.push_back(level);
  }
}

// Adds the roads of the map, in the same order, with cross sections that fit between the buildings.
void Layout::takeRoads(const MapPlace& map) {
  constexpr double kFarthestWall = 20;  // m; walls farther from the centre line do not narrow a road
  mainFrom = map.mainFrom;
  mainTo = map.mainTo;
  std::vector<Road> roads;
  RoadNetwork unnarrowed;
  for (const MapRoad& mapped : map.roads) {
    roads.push_back({.line = mapped.line,
                     .section = sectionOf(mapped, character, Draw(seed, Kind::MapRoad, roads.size())),
                     .main = roads.empty(),
                     .minor = mapped.kind >= RoadClass::Service,
                     .ring = mapped.ring,
                     .joins = mapped.joins,
                     .joinsLeft = mapped.joinsLeft,
                     .along = !mapped.oneWay || !mapped.against,
                     .against = !mapped.oneWay || mapped.against});
    unnarrowed.add(roads.back());
  }
  std::vector<std::vector<double>> walls(roads.size());  // m from the centre line, by road
  for (const MapBuilding& b : map.buildings) {
    std::vector<std::pair<std::uint32_t, double>> wallPoints;  // (road, m from its centre line)
    double nearest = 1e9;
    for (const Point2& p : pointsAlong(b.outline, 1.5)) {
      const Beside beside = unnarrowed.at(p);
      if (!beside.nearRoad) continue;
      const double lateral = std::abs(beside.lateral);
      if (lateral < kFarthestWall) wallPoints.emplace_back(beside.road, lateral);
      nearest = std::min(nearest, lateral);
    }
    // Buildings on a road do not narrow the road: takeBuildings() leaves them out.
    if (nearest < kOnRoad) continue;
    for (const auto& [road, lateral] : wallPoints) walls[road].push_back(lateral);
  }
  for (std::size_t r = 0; r < roads.size(); ++r) {
    narrowBetweenWalls(roads[r].section, walls[r]);
    network_.add(std::move(roads[r]));
  }
  for (const Point2& joint : map.joints) network_.addJoint(joint);
}

// Adds a house or, if isHouse() is false, a block for each building of the map. Leaves out buildings on roads. Adds a
// plot for each building near a road, except sheds and buildings that hang above the ground.
void Layout::takeBuildings(const MapPlace& map) {
  constexpr double kFacing = 30;       // m; a building farther from a sidewalk gets no plot
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
    warn("{}: left out: {} buildings that stand on a road of the town about {:.6f}, {:.6f}", parameters.map.string(),
         leftOut, map.origin.latitude, map.origin.longitude);
  }
  arrangePlots();
}

// Adds squares to `covers` that together cover a building. `around`: a rectangle around the building.
void Layout::cover(const MapBuilding& building, const Footprint& around) {
  constexpr double kCell = 1.6;  // m, side of the small squares
  std::vector<const Polygon*> rings{&building.outline};
  for (const Polygon& court : building.courts) rings.push_back(&court);
  for (const double v : models::steps(-around.halfY + kCell / 2, around.halfY + kCell / 2, kCell)) {
    for (const double u : models::steps(-around.halfX + kCell / 2, around.halfX + kCell / 2, kCell)) {
      const Point2 p = around.at(u, v);
      if (isInside(rings, p) || distanceToRings(rings, p) < kCell) {
        covers.push_back(Footprint::square(p, kCell / 2, around.yaw));
      }
    }
  }
}

// Adds bare plots at one side of a road, from `from` to `to` (m). Returns the last plot's end, or `from` if none fits.
double Layout::addBarePlots(const Road& road, int side, double from, double to) {
  constexpr double kLeastPlot = 8;  // m; a shorter interval gets no plot
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

// Sorts the plots along the roads, removes overlaps, and adds bare plots between them. Then removes plots whose front
// is on a parking lot, a square, water or another road, and sets the numbers and fences of the remaining plots.
void Layout::arrangePlots() {
  constexpr double kEnd = 4;  // m, length without bare plots at each end of a road
  std::stable_sort(plots.begin(), plots.end(), [](const Plot& a, const Plot& b) {
    return std::tie(a.road, a.side, a.from) < std::tie(b.road, b.side, b.from);
  });
  std::vector<Plot> built = std::move(plots);
  plots.clear();
  auto nextBuilt = built.begin();
  for (const Road& road : roads()) {
    for (const int side : {-1, 1}) {
      double end = kEnd;  // m along the road, end of the last plot so far
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
