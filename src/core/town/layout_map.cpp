// Takes roads, buildings and land from a map instead of sampling them.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/text.h"
#include "town/layout.h"

namespace scanmill::town {
namespace {

using models::Footprint;
using models::Kind;

constexpr double kOnRoad = 1.6;  // m; buildings that are nearer to a centre line count as on the road

// Returns the parameters with the map's district if they leave it open.
Parameters inDistrict(Parameters parameters, const std::string& district) {
  if (parameters.district == "any") parameters.district = district;
  return parameters;
}

// Returns the cross section of a road on the map. If the map gives no width: the usual width of the class; for
// residential roads a random one near that of the town's random roads. One-way roads are narrower. Service roads,
// tracks and roundabouts have neither sidewalks nor parking lanes.
CrossSection sectionOf(const MapRoad& road, const Character& c, Draw draw) {
  constexpr double kWidths[] = {7.5, 7, 6.4, 0, 3.8, 2.7};  // m, by RoadClass, estimates; 0: residential roads
  constexpr double kRingWidth = 6.5, kOneWayShare = 0.65;   // m; part of the width of a two-way road
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

// Narrows a cross section, but not below its least widths, so that the carriageway ends before nearly all walls beside
// the road, and the pavement before most of them: first the verge, then the sidewalk, the parking lane and the lanes.
// `walls`: distances of the walls from the centre line (m), in any order.
void narrowBetweenWalls(CrossSection& s, std::vector<double> walls) {
  constexpr double kGap = 0.4;            // m, width kept free between the carriageway and the nearest wall that counts
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
    const auto isFar = [&](const Point2& p) {
      return std::max(std::abs(p.x), std::abs(p.y)) <= halfSide && !besideAt(p).nearRoad;
    };
    if (std::ranges::any_of(pointsAlong(area.outline, 10), isFar)) {
      warn(fmt::format("{}: woods farther than {} m from every road have no trees", parameters.map.string(),
                       RoadNetwork::kReach));
    }
  }
  takeBuildings(map);
  for (const MapPath& path : map.paths) {
    constexpr double kOverlap = 0.2;  // m, at both ends of each segment
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
  constexpr double kBelow = 0.3;  // m between the water and the lowest point of its shore
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

// Adds the roads of the map, in its order, with cross sections that fit between its buildings.
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
    std::vector<std::pair<std::uint32_t, double>> wallPoints;  // roads, and distances from their centre lines (m)
    double nearest = 1e9;
    for (const Point2& p : pointsAlong(b.outline, 1.5)) {
      const Beside beside = unnarrowed.at(p);
      if (!beside.nearRoad) continue;
      const double lateral = std::abs(beside.lateral);
      if (lateral < kFarthestWall) wallPoints.emplace_back(beside.road, lateral);
      nearest = std::min(nearest, lateral);
    }
    // Buildings that stand across a road do not narrow it: takeBuildings() leaves them out.
    if (nearest < kOnRoad) continue;
    for (const auto& [road, lateral] : wallPoints) walls[road].push_back(lateral);
  }
  for (std::size_t r = 0; r < roads.size(); ++r) {
    narrowBetweenWalls(roads[r].section, walls[r]);
    network_.add(std::move(roads[r]));
  }
  for (const Point2& joint : map.joints) network_.addJoint(joint);
}

}  // namespace scanmill::town
