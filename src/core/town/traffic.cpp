// Places vehicles and cyclists that drive on the lanes by the model of flow.h. The right-hand lane of the main road is
// free for the ego vehicle.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "base/path.h"
#include "town/flow.h"
#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;

constexpr double kHeavyLane = 3.2;  // m, least width of a lane that lorries and buses use
constexpr double kUpstream = 1000;  // m of the route before the town, on which vehicles that arrive later start
constexpr double kBeyond = 300;     // m, distance beyond the town at which vehicles disappear, out of sight
constexpr double kWarmUp = 20;      // s of simulation before the drive begins
constexpr double kDuration = 120;   // s; all vehicles stand still after this time
constexpr double kInterval = 0.25;  // s between the stored positions of a vehicle
constexpr double kBeforeEnd = 0.1;  // m before the end of a route, where vehicles stop that do not vanish
constexpr double kStartGap = 22;    // m between vehicles at the start, besides a second of driving
constexpr double kAlways = -1e9;    // s, start time of vehicles that never wait
constexpr std::uint32_t kPassing = 1 << 20;  // first number of the lanes beside the rightmost ones

// A lane path of a vehicle in the world.
struct VehiclePath {
  std::shared_ptr<const Path> path;
  LanePoints lane;  // with its points in the world's frame

  // Returns the distance along the path (m) at a position on a road.
  double at(std::uint32_t road, double along) const {
    const auto distanceOf = [&](std::size_t i) { return path->distanceOfPoint(lane.firstOnRoad + i); };
    std::optional<std::size_t> before;
    for (std::size_t i = 0; i < lane.positions.size(); ++i) {
      if (lane.positions[i].road != road) continue;
      const double to = lane.positions[i].along;
      const double from = before ? lane.positions[*before].along : to;
      if ((from - along) * (to - along) <= 0 && from != to) {
        return distanceOf(*before) + (distanceOf(i) - distanceOf(*before)) * (along - from) / (to - from);
      }
      before = i;
    }
    return before ? distanceOf(*before) : 0;
  }
};

VehiclePath vehiclePath(const Layout& l, const LanePath& lanePath, double out, double halfWidth,
                        const Affine& worldFromTown) {
  LanePoints lane = lanePoints(l, lanePath, out, halfWidth + kMiddle);
  for (Vec3d& p : lane.points) p = worldFromTown * p;
  auto path = std::make_shared<const Path>(lane.points);
  return {std::move(path), std::move(lane)};
}

class Traffic {
 public:
  explicit Traffic(Placer& placer) : placer_(placer), l_(placer.layout), main_(road(0)) {
    fastest_ = l_.character.speed;
  }

  void place() {
    addThrough();
    addPassing();
    for (const Road& side : l_.roads()) addSideRoad(side);
    drawThrough();
    const std::vector<std::vector<double>> travelled = drive(routes_, drivers_, kWarmUp, kDuration, kInterval);
    for (std::size_t i = 0; i < drivers_.size(); ++i) {
      const Participant& p = participants_[i];
      const double halfWidth = (p.vehicle.bounds.high.y - p.vehicle.bounds.low.y) / 2;
      const VehiclePath driven =
          vehiclePath(l_, lanePaths_[drivers_[i].route], p.out, halfWidth, placer_.worldFromTown);
      const auto movement = std::make_shared<const Movement>(driven.path, travelled[i], kInterval);
      placer_.putMoving(p.vehicle.mesh, p.name, movement);
      if (p.rider) placer_.putMoving(p.rider->mesh, "rider of " + p.name, movement);
    }
  }

 private:
  struct Participant {
    Model vehicle;
    std::optional<Model> rider;
    double out = 0;
    std::string name;
  };

  const Road& road(std::uint32_t r) const { return l_.roads()[r]; }
  static std::uint32_t inwards(std::uint32_t r) { return 2 * r; }
  static std::uint32_t outwards(std::uint32_t r) { return 2 * r + 1; }

  // Adds a route `out` metres to the right of the middle of the rightmost lane. Returns its index.
  std::uint32_t add(const LanePath& lanePath, double out = 0) {
    lanePaths_.push_back(lanePath);
    paths_.push_back(vehiclePath(l_, lanePath, out, 0, placer_.worldFromTown));
    const Path& path = *paths_.back().path;
    std::vector<double> curvature;
    for (const double d : models::steps(0, path.length(), kLimitStep)) curvature.push_back(path.curvature(d, 4));
    Route route;
    route.length = path.length();
    route.limit = inBends(curvature, fastest_);
    routes_.push_back(std::move(route));
    return static_cast<std::uint32_t>(routes_.size() - 1);
  }

  // Returns where an object first blocks the lane between two places of a road (m along the road); nullopt if the lane
  // is free.
  std::optional<double> blocked(std::uint32_t r, double from, double to) const {
    const double direction = to >= from ? 1 : -1;
    const double lateral = road(r).oneWay() ? 0 : std::max(road(r).laneMiddle(), 0.9 + kMiddle);
    for (const double done : models::steps(0, std::abs(to - from), 1.5)) {
      const double along = from + direction * done;
      const Spot spot = besideRoad(road(r), along, -direction * lateral);
      if (!placer_.occupancy.isFree({spot.at, 0.75, 0.9, spot.yaw})) return along;
    }
    return std::nullopt;
  }

  // Adds the route through the town: the complete main road, driven against its line.
  void addThrough() {
    const double length = main_.length();
    const std::uint32_t route = add({{{0, length, 0}}, kUpstream, kBeyond});
    Route& through = routes_[route];
    through.legs = {{0, 0, through.length, 0}};
    // A vehicle that starts behind an obstacle may have another one ahead.
    constexpr double kNext = 26;  // m from the beginning of an obstacle, from where the next one is looked for
    for (auto at = blocked(0, length, 0); at; at = *at > kNext ? blocked(0, *at - kNext, 0) : std::nullopt) {
      through.stops.push_back({paths_[route].at(0, *at) - 2});
    }
    addLights(route, &Placer::Light::along);
  }

  // Adds the stop lines of the main road's lights to a route. `position`: where the route's vehicles stop.
  void addLights(std::uint32_t route, double Placer::Light::*position) {
    for (const Placer::Light& light : placer_.lights) {
      routes_[route].stops.push_back({paths_[route].at(0, light.*position), light.kPeriod, light.kRed, light.offset});
    }
  }

  // Adds the routes of the other lanes, in both directions, and their vehicles. Nobody changes lanes.
  void addPassing() {
    if (main_.oneWay()) return;
    const double length = main_.length();
    for (int lane = 1; lane < main_.section.lanes; ++lane) {
      for (const bool along : {false, true}) {
        const LanePath lanePath{{{0, along ? 0 : length, along ? length : 0}}, kUpstream, kBeyond};
        const std::uint32_t number = kPassing + 2 * static_cast<std::uint32_t>(lane) + (along ? 1 : 0);
        const std::uint32_t route = add(lanePath, -lane * main_.section.laneWidth());
        routes_[route].legs = {{number, 0, routes_[route].length, 0}};
        addLights(route, along ? &Placer::Light::facing : &Placer::Light::along);
        Draw draw(l_.seed, Kind::PassingTraffic, number);
        drawAlong(draw, route, l_.character.traffic, -lane * main_.section.laneWidth());
      }
    }
  }

  // Adds the routes into and out of a side road and their vehicles. Vehicles turn from and to the main road only at its
  // left, where they do not cross the ego vehicle's lane; elsewhere they stop at the ends of the side road's lanes.
  void addSideRoad(const Road& side) {
    constexpr double kLeastLanes = 20;  // m
    const std::uint32_t r = side.number;
    const double end = laneEnd(side);
    const double start = laneStart(l_);
    if (!side.joins || end < start + kLeastLanes || egoRoads(l_).has(side)) return;
    const bool turns = side.joinsLeft && main_.against;
    std::optional<std::uint32_t> out;
    std::optional<std::uint32_t> in;
    if (side.along && !blocked(r, start, end)) {
      out = add({{{r, start, end}}});
      routes_[*out].legs = {{outwards(r), 0, routes_[*out].length, 0}};
      routes_[*out].stops = {{routes_[*out].length - kBeforeEnd}};
      if (turns) addTurnInto(side);
    }
    if (side.against && !blocked(r, end, start)) in = turns ? addTurnOutOf(side) : addUpToStopLine(side);
    drawSide(r, in, out, start, end);
  }

  // Adds the route from the main road into a side road.
  void addTurnInto(const Road& side) {
    constexpr double kOverlap = 4;  // m before its own lane where a turning vehicle is seen by those on that lane
    const double before = *side.joins + turnStart(side);
    const std::uint32_t number =
        add({.intervals = {{0, main_.length(), before}, {side.number, laneStart(l_), laneEnd(side)}},
             .hiddenBefore = kUpstream});
    Route& turning = routes_[number];
    const double from = paths_[number].at(side.number, laneStart(l_));
    turning.legs = {{.lane = 0, .from = 0, .to = from},
                    {.lane = outwards(side.number), .from = from - kOverlap, .to = turning.length, .shift = -from}};
    turning.stops = {{turning.length - kBeforeEnd}};
    for (const StopLine& s : routes_.front().stops) {
      if (s.at < paths_[number].at(0, before)) turning.stops.push_back(s);
    }
    turns_.push_back(number);
  }

  // Adds the route along a side road to its stop line, where vehicles wait for ever.
  std::uint32_t addUpToStopLine(const Road& side) {
    const std::uint32_t number = add({{{side.number, laneEnd(side), stopLineOfSideRoad(l_)}}});
    Route& coming = routes_[number];
    coming.legs = {{inwards(side.number), 0, coming.length, 0}};
    coming.stops = {{paths_[number].at(side.number, stopLineOfSideRoad(l_)) - kBeforeEnd}};
    return number;
  }

  // Adds the route from a side road to the main road, to which it gives way at its stop line.
  std::uint32_t addTurnOutOf(const Road& side) {
    constexpr double kLooksBack = 50, kLooksAhead = 14;  // m of the main road from the junction that must be free
    constexpr double kLeaves = 6, kEnters = 1;           // m behind the stop line: end and start of the lanes
    const double after = *side.joins - turnStart(side);
    const std::uint32_t r = side.number;
    const std::uint32_t number = add({{{r, laneEnd(side), stopLineOfSideRoad(l_)}, {0, after, 0}}, 0, kBeyond});
    Route& coming = routes_[number];
    const double line = paths_[number].at(r, stopLineOfSideRoad(l_));
    const double merged = paths_[number].at(0, after);   // m along this route
    const double through = paths_.front().at(0, after);  // m along the route through the town
    coming.legs = {{inwards(r), 0, line + kLeaves, 0}, {0, line + kEnters, coming.length, through - merged}};
    coming.stops = {{line, 0, 0, 0, true, 0, through - kLooksBack, through + kLooksAhead}};
    for (const StopLine& s : routes_.front().stops) {
      if (s.at > through) coming.stops.push_back({s.at + merged - through, s.period, s.red, s.offset});
    }
    return number;
  }

  void drawSide(std::uint32_t r, const std::optional<std::uint32_t>& in, const std::optional<std::uint32_t>& out,
                double mouth, double end) {
    Draw draw(l_.seed, Kind::SideTraffic, r);
    const int count = static_cast<int>(l_.character.traffic * 0.4 * (end - mouth) / 100 + draw.next());
    std::vector<std::pair<std::uint32_t, double>> taken;
    for (int k = 0; k < count; ++k) {
      const bool inwardsBound = draw.chance(0.5);
      const std::optional<std::uint32_t>& route = inwardsBound ? in : out;
      const double at = draw.in(4, std::max(5.0, end - mouth - 12));
      const double starts = draw.chance(0.5) ? draw.in(0, 40) : kAlways;
      const Model& car = anyCar(placer_, draw);
      const double off = draw.in(-0.15, 0.15);
      if (!route) continue;
      const bool near = std::any_of(taken.begin(), taken.end(),
                                    [&](const auto& t) { return t.first == *route && std::abs(t.second - at) < 14; });
      if (near) continue;
      taken.emplace_back(*route, at);
      addDriver(*route, at, car, std::nullopt, draw.in(6, 10), off, starts);
    }
  }

  // Adds the vehicles that drive through the town. They start at least kStartGap plus one second of driving apart.
  void drawThrough() {
    if (!main_.against) return;
    Draw draw(l_.seed, Kind::Traffic);
    const double density = l_.character.traffic / 100;
    const double length = routes_.front().length;
    int riding = ridersWanted();
    const double built = paths_.front().at(0, l_.mainTo);
    const double last = paths_.front().at(0, l_.mainFrom);
    double at = draw.in(0, 30);
    while (at < length - kBeyond) {
      const double speed = fastest_ * draw.in(0.85, 1.1);
      const double pick = draw.next();
      const double off = draw.in(-0.2, 0.2);
      if (riding > 0 && at > built && at < last) {
        --riding;
        addCyclist(draw, at);
      } else if (density > 0) {
        const bool heavy = pick < 0.27 && main_.section.laneWidth() > kHeavyLane;
        if (pick > 0.8) {
          addMotorcyclist(draw, 0, at, speed, off);
          at += kStartGap + speed;
          continue;
        }
        const Model& m = !heavy ? anyCar(placer_, draw) : pick < 0.16 ? busOf(placer_) : anyTruck(placer_, draw);
        const bool turns = !heavy && !turns_.empty() && draw.chance(0.25);
        std::uint32_t route = 0;
        if (turns) route = draw.itemOf(turns_);
        const std::vector<Leg>& legs = routes_[route].legs;
        // Lorries and buses keep to the middle of the lane: in bends they need its width.
        addDriver(at < legs.front().to - 30 ? route : 0, at, m, std::nullopt, speed, heavy ? 0 : off, kAlways);
      }
      const double least = kStartGap + speed;
      const double mean = density > 0 ? std::max(1 / density - least, 8.0) : 40;
      at += least - mean * std::log(draw.next());
    }
  }

  // Adds the vehicles of a route that nobody leaves, `out` metres to the right of the rightmost lane. `per100m`:
  // vehicles per 100 m of the lane.
  void drawAlong(Draw& draw, std::uint32_t route, double per100m, double out) {
    const double length = routes_[route].length;
    double at = draw.in(0, 30);
    while (per100m > 0 && at < length - kBeyond) {
      const double speed = 1.1 * fastest_ * draw.in(0.9, 1.1);
      const double off = draw.in(-0.2, 0.2);
      const bool heavy = draw.chance(0.08) && main_.section.laneWidth() > kHeavyLane;
      if (draw.chance(0.2)) {
        addMotorcyclist(draw, route, at, speed, out + off);
      } else {
        addDriver(route, at, heavy ? anyTruck(placer_, draw) : anyCar(placer_, draw), std::nullopt, speed, out + off,
                  kAlways);
      }
      const double least = kStartGap + speed;
      at += least - std::max(100 / per100m - least, 8.0) * std::log(draw.next());
    }
  }

  int ridersWanted() const {
    if (l_.parameters.people <= 0 || l_.character.motorway) return 0;
    Draw draw(l_.seed, Kind::RoadCyclists);
    const double length = l_.mainTo - l_.mainFrom;
    return std::max(1, static_cast<int>(0.7 * l_.character.people * length / 100 + draw.next()));
  }

  void addCyclist(Draw& draw, double at) {
    const int form = draw.below(static_cast<int>(cyclists_.size()));
    std::optional<models::Ridden>& pair = cyclists_[static_cast<std::size_t>(form)];
    if (!pair) pair = models::makeCyclist(placer_.builder, l_.seed, form);
    const double speed = draw.in(3.5, 6);
    constexpr double kBesideParked = 1;  // m from the lane's middle, where cyclists pass parked cars
    const double out = std::min(main_.section.laneWidth() / 2 - 0.6, kBesideParked);
    addDriver(0, at, pair->vehicle, pair->rider, speed, out, kAlways, "cyclist's bicycle");
  }

  void addMotorcyclist(Draw& draw, std::uint32_t route, double at, double speed, double out) {
    const int form = draw.below(static_cast<int>(motorcyclists_.size()));
    std::optional<models::Ridden>& pair = motorcyclists_[static_cast<std::size_t>(form)];
    if (!pair) pair = models::makeMotorcyclist(placer_.builder, l_.seed, form);
    addDriver(route, at, pair->vehicle, pair->rider, speed, out, kAlways, "traffic on a motorcycle");
  }

  // Adds a vehicle that starts at `at` (m along the route), unless a line is too near. `what` begins its name.
  void addDriver(std::uint32_t route, double at, const Model& vehicle, const std::optional<Model>& rider, double speed,
                 double out, double starts, std::string_view what = "traffic") {
    const double length = vehicle.bounds.high.x - vehicle.bounds.low.x;
    // No vehicle starts within 14 m before a StopLine without a traffic light, a give-way line or an obstacle such
    // as roadworks, or within 26 m behind it.
    for (const StopLine& s : routes_[route].stops) {
      if (s.period <= 0 && at > s.at - 14 && at < s.at + 26) return;
    }
    drivers_.push_back({route, at, length, speed, starts});
    participants_.push_back({vehicle, rider, out, fmt::format("{} {}", what, ++numbers_[std::string(what)])});
  }

  Placer& placer_;
  const Layout& l_;
  const Road& main_;
  double fastest_ = 12;  // m/s, speed limit in the town
  std::vector<LanePath> lanePaths_;
  std::vector<VehiclePath> paths_;
  std::vector<Route> routes_;
  std::vector<std::uint32_t> turns_;  // indices of routes that leave the main road
  std::vector<Driver> drivers_;
  std::vector<Participant> participants_;
  std::map<std::string, int> numbers_;  // of drivers, by the beginnings of their names
  std::array<std::optional<models::Ridden>, kRoadCyclistForms> cyclists_;  // built when they are first needed
  std::array<std::optional<models::Ridden>, 2> motorcyclists_;
};

}  // namespace

void placeTraffic(Placer& placer) {
  Traffic(placer).place();
}

}  // namespace scanmill::town
