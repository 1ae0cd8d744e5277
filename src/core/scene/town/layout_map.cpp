// What a map says, in place of what the seed would draw: roads, buildings, land.

#include <algorithm>
#include <cmath>
#include <tuple>

#include "scene/town/layout.h"

namespace scanmill::town {
namespace {

using parts::Fencing;
using parts::Footprint;
using parts::House;
using parts::Kind;
using parts::Roof;

constexpr double kPath = 0.9;  // m, half of a path's width

Parameters inDistrict(Parameters parameters, District district) {
  if (parameters.district != "any") return parameters;
  parameters.district = district == District::Rural ? "rural" : district == District::Dense ? "dense" : "suburban";
  return parameters;
}

// Where the map is silent: usual widths by the road's class, and the place's own.
CrossSection sectionOf(const MapRoad& road, const Character& c, Draw draw) {
  const bool small = road.kind >= RoadClass::Service;
  const double lane = c.main.half - c.main.parking;
  double width = 2 * lane;
  switch (road.kind) {
    case RoadClass::Primary:
      width = 7.5;
      break;
    case RoadClass::Secondary:
      width = 7;
      break;
    case RoadClass::Tertiary:
      width = 6.4;
      break;
    case RoadClass::Residential:
      width = 2 * lane * draw.in(0.85, 1.05);
      break;
    case RoadClass::Service:
      width = 3.8;
      break;
    case RoadClass::Track:
      width = 2.7;
      break;
  }
  if (road.oneWay && !small) width = road.ring ? 6.5 : 0.65 * width;
  CrossSection s = small ? CrossSection{} : c.main;
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

// Carriageways end before walls; pavements give way to most of them.
void makeRoom(CrossSection& s, std::vector<double>& walls) {
  constexpr double kGap = 0.4;      // m
  constexpr double kLeast = 1.6;    // m, half of the narrowest road
  constexpr double kBehind = 0.15;  // share of the walls that may stand on the pavement
  if (walls.empty()) return;
  std::sort(walls.begin(), walls.end());
  const double most = walls[static_cast<std::size_t>(kBehind * static_cast<double>(walls.size() - 1))];
  const auto lack = [&] { return s.half + s.outer() - most; };
  s.verge -= std::clamp(lack(), 0.0, s.verge);
  if (s.sidewalk > 0.6) s.sidewalk -= std::clamp(lack(), 0.0, s.sidewalk - 0.6);
  if (s.half + kGap > walls.front() && s.parking > 0) {
    s.half -= s.parking;
    s.parking = 0;
  }
  s.half = std::max(kLeast, std::min(s.half, walls.front() - kGap));
}

template <class Visit>
void alongRing(const Polygon& ring, double step, const Visit& visit) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point2& a = ring[i];
    const Point2& b = ring[(i + 1) % ring.size()];
    const auto count = std::max(1, static_cast<int>(std::hypot(b.x - a.x, b.y - a.y) / step));
    for (int k = 0; k < count; ++k) {
      const double t = static_cast<double>(k) / count;
      visit(Point2{a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t});
    }
  }
}

int floorsOf(const MapBuilding& b, const Character& c, Draw& draw) {
  constexpr double kStorey = 2.9;  // m
  const int drawn = c.floorsLow + draw.below(c.floorsHigh - c.floorsLow + 1);
  if (b.floors) return *b.floors;
  if (b.height) return std::max(1, static_cast<int>(std::lround(*b.height / kStorey)));
  return drawn;
}

}  // namespace

Layout::Layout(const Parameters& parameters, std::uint64_t seed, const MapPlace& map)
    : parameters_(inDistrict(parameters, map.district)),
      seed_(seed),
      character_(parameters_, seed),
      half_(reachOf(parameters)),
      barriers_(map.barriers),
      trees_(map.trees) {
  takeRoads(map);
  drawPotholes();
  for (const MapArea& area : map.areas) areas_.add(area);
  takeBuildings(map);
  for (const std::vector<Point2>& path : map.paths) {
    for (std::size_t i = 1; i < path.size(); ++i) {
      const Point2& a = path[i - 1];
      const Point2& b = path[i];
      const Point2 middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
      patches_.push_back({{middle, std::hypot(b.x - a.x, b.y - a.y) / 2 + 0.2, kPath, std::atan2(b.y - a.y, b.x - a.x)},
                          GroundKind::Path});
    }
  }
  settle();
}

void Layout::takeRoads(const MapPlace& map) {
  mainFrom_ = map.mainFrom;
  mainTo_ = map.mainTo;
  std::vector<Road> roads;
  RoadNetwork wide;
  for (const MapPlace::PlacedRoad& placed : map.roads) {
    Road road;
    road.line = placed.road.line;
    road.section = sectionOf(placed.road, character_,
                             Draw(seed_, Kind::SideRoad, 1000 + static_cast<std::uint32_t>(roads.size())));
    road.main = roads.empty();
    road.joins = placed.joins;
    road.joinsLeft = placed.joinsLeft;
    road.against = !placed.road.oneWay || placed.road.against;
    road.along = !placed.road.oneWay || !placed.road.against;
    wide.add(road);
    roads.push_back(std::move(road));
  }
  std::vector<std::vector<double>> walls(roads.size());
  for (const MapBuilding& b : map.buildings) {
    alongRing(b.outline, 1.5, [&](const Point2& p) {
      const Beside beside = wide.at(p.x, p.y);
      const double lateral = std::abs(beside.lateral);
      if (beside.known && lateral < 20) walls[beside.road].push_back(lateral);
    });
  }
  for (std::size_t r = 0; r < roads.size(); ++r) {
    makeRoom(roads[r].section, walls[r]);
    roads_.add(std::move(roads[r]));
  }
  for (const Point2& joint : map.joints) roads_.addJoint(joint);
}

// Houses over rectangles; blocks over all other outlines. What faces a road has a plot there.
void Layout::takeBuildings(const MapPlace& map) {
  std::uint32_t number = 0;
  for (const MapBuilding& b : map.buildings) {
    Draw draw(seed_, Kind::Plot, 500000 + number);
    const int floors = floorsOf(b, character_, draw);
    const Footprint about = rectangleAbout(b.outline);
    // The side that is nearest to a road.
    double nearest = 1e9;
    int front = 0;
    Beside before;
    for (int side = 0; side < 4; ++side) {
      const double angle = about.yaw + side * kPi / 2;
      const double out = side % 2 == 0 ? about.halfX : about.halfY;
      const Point2 p{about.center.x + out * std::cos(angle), about.center.y + out * std::sin(angle)};
      const Beside beside = roads_.at(p.x, p.y);
      if (!beside.known || beside.edge - beside.section.outer() >= nearest) continue;
      nearest = beside.edge - beside.section.outer();
      front = side;
      before = beside;
    }
    const double halfWidth = front % 2 == 0 ? about.halfY : about.halfX;
    const double halfDepth = front % 2 == 0 ? about.halfX : about.halfY;
    const double facing = about.yaw + front * kPi / 2;  // the direction to the road
    const bool rectangular = sizeOf(b.outline) > 0.9 * 4 * about.halfX * about.halfY && b.courts.empty();
    const bool house = rectangular && !b.shed && halfWidth > 2.4 && halfDepth > 2.2 && halfWidth < 20 && halfDepth < 9;
    if (house) {
      House made = drawHouse(draw, number, 2 * halfWidth, 2 * halfDepth, floors);
      made.shop = b.shop;
      if (b.roof) made.roof = *b.roof;
      made.forecourt = std::max(0.0, std::min(nearest, 30.0));
      const double yaw = facing + kPi / 2;
      const double c = std::cos(yaw);
      const double s = std::sin(yaw);
      made.place = parts::at(
          {about.center.x - c * halfWidth + s * halfDepth, about.center.y - s * halfWidth - c * halfDepth, 0}, yaw);
      houses_.push_back(std::move(made));
    } else {
      PlacedBlock placed;
      placed.about = about;
      const double out = halfDepth + 0.6;
      placed.entrance = {about.center.x + out * std::cos(facing), about.center.y + out * std::sin(facing)};
      parts::Block& block = placed.block;
      block.number = number;
      block.floors = b.shed ? 0 : floors;
      block.height = b.shed ? std::min(b.height.value_or(2.6), 8.0) : b.height.value_or(0);
      block.shop = b.shop;
      const auto relative = [&](const Polygon& ring) {
        Polygon made;
        for (const Point2& p : ring) made.push_back({p.x - about.center.x, p.y - about.center.y});
        return made;
      };
      block.entrance = {placed.entrance.x - about.center.x, placed.entrance.y - about.center.y};
      block.outline = relative(b.outline);
      for (const Polygon& court : b.courts) block.courts.push_back(relative(court));
      blocks_.push_back(std::move(placed));
      std::vector<const Polygon*> rings{&b.outline};
      for (const Polygon& court : b.courts) rings.push_back(&court);
      cover(rings, about);
    }
    ++number;
    constexpr double kFacing = 30;  // m
    if (b.shed || nearest > kFacing) continue;
    Plot plot;
    plot.road = before.road;
    plot.side = before.lateral > 0 ? 1 : -1;
    plot.from = before.along - halfWidth - 1;
    plot.to = before.along + halfWidth + 1;
    plot.setback = std::max(nearest, 0.0);
    plot.depth = 2 * halfDepth;
    plot.built = true;
    plots_.push_back(plot);
    if (house && plot.setback > 0.6) {
      const Vec3d door = houses_.back().place * Vec3d{houses_.back().doorX(), -0.6, 0};
      addStrip({door.x, door.y}, facing + kPi / 2, kPath, plot.setback - 0.6 + before.section.outer(),
               GroundKind::Path);
    }
  }
  arrangePlots();
}

// Rectangles that cover what is built, walls and all within them.
void Layout::cover(const std::vector<const Polygon*>& rings, const Footprint& about) {
  constexpr double kCell = 1.6;  // m
  const double c = std::cos(about.yaw);
  const double s = std::sin(about.yaw);
  for (const double v : parts::steps(-about.halfY + kCell / 2, about.halfY + kCell / 2, kCell)) {
    for (const double u : parts::steps(-about.halfX + kCell / 2, about.halfX + kCell / 2, kCell)) {
      const Point2 p{about.center.x + u * c - v * s, about.center.y + u * s + v * c};
      if (isInside(rings, p) || distanceToRings(rings, p) < kCell) {
        covers_.push_back({p, kCell / 2, kCell / 2, about.yaw});
      }
    }
  }
}

// In their order along the roads, without overlaps, with plots where nobody has built between them.
void Layout::arrangePlots() {
  std::stable_sort(plots_.begin(), plots_.end(), [](const Plot& a, const Plot& b) {
    return std::tie(a.road, a.side, a.from) < std::tie(b.road, b.side, b.from);
  });
  std::vector<Plot> built = std::move(plots_);
  plots_.clear();
  std::size_t next = 0;
  for (std::uint32_t r = 0; r < roads_.roads().size(); ++r) {
    const Road& road = roads_.roads()[r];
    for (const int side : {-1, 1}) {
      double done = 4;
      const auto addFree = [&](double to) {
        while (to - done > 8) {
          Plot plot;
          plot.road = r;
          plot.side = side;
          plot.from = done;
          Draw draw(seed_, Kind::Plot, 800000 + static_cast<std::uint32_t>(plots_.size()));
          plot.to = std::min(to, done + draw.around(character_.plotWidth, 0.3));
          plot.setback = character_.setback;
          done = plot.to;
          plots_.push_back(plot);
        }
      };
      for (; next < built.size() && built[next].road == r && built[next].side == side; ++next) {
        Plot plot = built[next];
        plot.from = std::max(plot.from, done);
        plot.to = std::min(plot.to, road.length() - 2);
        if (plot.to - plot.from < 2) continue;  // behind another
        addFree(plot.from);
        plot.from = std::max(done, 4.0);
        done = plot.to;
        plots_.push_back(plot);
      }
      addFree(road.length() - 4);
    }
  }
  std::erase_if(plots_, [&](const Plot& plot) {
    // Not on lots, squares and water, nor where another road goes.
    const Road& road = roads_.roads()[plot.road];
    const double middle = (plot.from + plot.to) / 2;
    const Point2 p = road.point(middle);
    const Point2 h = road.heading(middle);
    const double out = plot.side * (road.section.half + road.section.outer() + 1.5);
    const Point2 front{p.x - h.y * out, p.y + h.x * out};
    const Beside b = roads_.at(front.x, front.y);
    return areas_.outsideHard(front) < 0.5 || (b.known && b.edge < b.section.outer());
  });
  for (std::uint32_t i = 0; i < plots_.size(); ++i) {
    Plot& plot = plots_[i];
    plot.number = i;
    Draw draw(seed_, Kind::Plot, 900000 + i);
    plot.fencing = drawFencing(draw, plot.setback);
  }
}

}  // namespace scanmill::town
