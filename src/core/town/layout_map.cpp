// Takes roads, buildings and land from a map instead of sampling them.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/text.h"
#include "town/layout.h"

namespace scanmill::town {
namespace {

using models::Kind;

constexpr double kOnRoad = 1.6;  // m; buildings that are nearer to a centre line count as on the road

Parameters inDistrict(Parameters parameters, const std::string& district) {
  if (parameters.district == "any") parameters.district = district;
  return parameters;
}

// Returns the cross section of a road on the map. If the map gives no width: the usual width of the class; for
// residential roads a random one near that of the town's random roads. One-way roads are narrower.
CrossSection sectionOf(const MapRoad& road, const Character& c, Draw draw) {
  const bool small = road.kind >= RoadClass::Service;
  const double lane = c.main.laneWidth();
  // m, widths by class; 0: residential roads
  constexpr double kWidths[] = {7.5, 7, 6.4, 0, 3.8, 2.7};
  double width = road.kind == RoadClass::Residential ? 2 * lane * draw.in(0.85, 1.05)
                                                     : kWidths[static_cast<std::size_t>(road.kind)];
  if (road.oneWay && !small) width = road.ring ? 6.5 : 0.65 * width;
  CrossSection s = small ? CrossSection{} : c.main;
  s.lanes = 1;
  s.shoulder = s.median = 0;
  const bool parked = draw.chance(0.4);
  const double bay = draw.in(1.9, 2.3);
  s.parking = small || road.ring || !road.parking.value_or(parked && c.main.parking > 0) ? 0 : bay;
  s.half = road.width.value_or(width) / 2 + s.parking;
  if (small || road.ring) {
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
// the road, and the pavement before most of them. `walls` has the walls' distances from the centre line (m).
void makeRoom(CrossSection& s, std::vector<double>& walls) {
  constexpr double kGap = 0.4;      // m, width kept free between the carriageway and the nearest wall that counts
  constexpr double kLeast = 1.6;    // m, half of the width of the narrowest road
  constexpr double kBehind = 0.15;  // fraction of the walls that may be on the pavement
  constexpr double kIgnored = 0.02;
  if (walls.empty()) return;
  std::sort(walls.begin(), walls.end());
  const auto at = [&](double share) {
    return walls[static_cast<std::size_t>(share * static_cast<double>(walls.size() - 1))];
  };
  const double most = at(kBehind);
  const double nearest = at(kIgnored);
  const auto lack = [&] { return s.half + s.outer() - most; };
  s.verge -= std::clamp(lack(), 0.0, s.verge);
  if (s.sidewalk > 0.6) s.sidewalk -= std::clamp(lack(), 0.0, s.sidewalk - 0.6);
  if (s.half + kGap > nearest && s.parking > 0) {
    s.half -= s.parking;
    s.parking = 0;
  }
  s.half = std::max(kLeast, std::min(s.half, nearest - kGap));
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
    const std::vector<Point2> edge = pointsAlong(area.outline, 10);
    const auto isFar = [&](const Point2& p) {
      return std::max(std::abs(p.x), std::abs(p.y)) <= halfSide && !besideAt(p).nearRoad;
    };
    if (std::any_of(edge.begin(), edge.end(), isFar)) {
      warn(fmt::format("{}: woods farther than {} m from every road have no trees", parameters.map.string(),
                       RoadNetwork::kReach));
    }
  }
  takeBuildings(map);
  for (const MapPath& path : map.paths) {
    const double half = path.width ? *path.width / 2 : kPathHalf;
    for (std::size_t i = 1; i < path.line.size(); ++i) {
      const Point2& a = path.line[i - 1];
      const Point2& b = path.line[i];
      const Point2 middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
      patches.push_back({TurnedRectangle({middle, std::hypot(b.x - a.x, b.y - a.y) / 2 + 0.2, half,
                                          std::atan2(b.y - a.y, b.x - a.x)}),
                         GroundKind::Path});
    }
  }
  setLevels();
}

void Layout::findWaterLevels() {
  constexpr double kBelow = 0.3;  // m between the water and the lowest point of its shore
  for (const MapArea& area : areas.all()) {
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

void Layout::takeRoads(const MapPlace& map) {
  mainFrom = map.mainFrom;
  mainTo = map.mainTo;
  std::vector<Road> roads;
  RoadNetwork wide;
  for (const MapRoad& placed : map.roads) {
    Road road;
    road.line = placed.line;
    road.section = sectionOf(placed, character, Draw(seed, Kind::MapRoad, roads.size()));
    road.main = roads.empty();
    road.minor = placed.kind >= RoadClass::Service;
    road.ring = placed.ring;
    road.joins = placed.joins;
    road.joinsLeft = placed.joinsLeft;
    road.against = !placed.oneWay || placed.against;
    road.along = !placed.oneWay || !placed.against;
    wide.add(road);
    roads.push_back(std::move(road));
  }
  std::vector<std::vector<double>> walls(roads.size());
  for (const MapBuilding& b : map.buildings) {
    std::vector<std::pair<std::uint32_t, double>> near;
    double least = 1e9;
    for (const Point2& p : pointsAlong(b.outline, 1.5)) {
      const Beside beside = wide.at(p);
      const double lateral = std::abs(beside.lateral);
      if (beside.nearRoad && lateral < 20) near.emplace_back(beside.road, lateral);
      if (beside.nearRoad) least = std::min(least, lateral);
    }
    // Buildings that stand across a road do not narrow it: takeBuildings() leaves them out.
    if (least < kOnRoad) continue;
    for (const auto& [road, lateral] : near) walls[road].push_back(lateral);
  }
  for (std::size_t r = 0; r < roads.size(); ++r) {
    makeRoom(roads[r].section, walls[r]);
    network_.add(std::move(roads[r]));
  }
  for (const Point2& joint : map.joints) network_.addJoint(joint);
}

}  // namespace scanmill::town
