// Places driving vehicles and cyclists, simulated by flow.h, on all lanes but the ego vehicle's lane of the main road.

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

constexpr double kHeavyLane = 3.2;           // m, least width of a lane that lorries and buses use
constexpr double kUpstream = 1000;           // m of the route before the town, for vehicles that arrive later
constexpr double kBeyond = 300;              // m of the route beyond the town, after which vehicles disappear
constexpr double kWarmUp = 20;               // s, simulated before time 0
constexpr double kDuration = 120;            // s; all vehicles stand still after this time
constexpr double kInterval = 0.25;           // s between the stored positions of a vehicle
constexpr double kBeforeEnd = 0.1;           // m from a last stop line to the route's end, where vehicles would vanish
constexpr double kStartGap = 22;             // m between vehicles at the start, plus the distance driven in 1 s
constexpr double kAlways = -1e9;             // s, start time of vehicles that never wait
constexpr std::uint32_t kPassing = 1 << 20;  // first number of the passing lanes

// The path of a vehicle along lanes, in the world's frame.
struct VehiclePath {
  std::shared_ptr<const Path> path;
  LanePoints lane;  // `points` are in the world's frame

  // Returns the distance (m) along the path at which the path passes `along` (m) on a road. If the path does not pass
  // there, returns the distance of its last point on the road, or 0 if no point is on the road.
  double distanceAt(std::uint32_t road, double along) const {
    const auto distanceOf = [&](std::size_t i) { return path->distanceOfPoint(lane.firstOnRoad + i); };
    std::optional<std::size_t> previous;  // index of the previous point on the road
    for (std::size_t i = 0; i < lane.positions.size(); ++i) {
      if (lane.positions[i].road != road) continue;
      const double end = lane.positions[i].along;
      const double start = previous ? lane.positions[*previous].along : end;
      if ((start - along) * (end - along) <= 0 && start != end) {
        return distanceOf(*previous) + (distanceOf(i) - distanceOf(*previous)) * (along - start) / (end - start);
      }
      previous = i;
    }
    return previous ? distanceOf(*previous) : 0;
  }
};

// Returns the path of a vehicle of half width `halfWidth` along lanes, `out` m to the right of the middle of the
// rightmost lane. On two-way roads the vehicle's left side is at least kMiddle from the centre line; on one-way roads,
// the path is `out` m to the right of the centre line.
VehiclePath vehiclePath(const Layout& l, const LanePath& lanePath, double out, double halfWidth,
                        const Affine& worldFromTown) {
  LanePoints lane = lanePoints(l, lanePath, [&](const Road& road) {
    return road.oneWay() ? out : std::max(road.laneMiddle() + out, halfWidth + kMiddle);
  });
  for (Vec3d& p : lane.points) p = worldFromTown * p;
  auto path = std::make_shared<const Path>(lane.points);
  return {std::move(path), std::move(lane)};
}

// Places the traffic of a town: adds routes (first the route through the town), adds vehicles and simulates them.
class Traffic {
 public:
  explicit Traffic(Placer& placer) : placer_(placer), l_(placer.layout), main_(road(0)), fastest_(l_.character.speed) {}

  // The order counts: later routes copy the stop lines of the first route, and vehicles choose among all routes.
  void place() {
    addThrough();
    addPassing();
    for (const Road& side : l_.roads()) addSideRoad(side);
    drawThrough();
    const std::vector<std::vector<double>> travelled = drive(routes_, drivers_, kWarmUp, kDuration, kInterval);
    for (std::size_t i = 0; i < drivers_.size(); ++i) {
      const Participant& p = participants_[i];
      const VehiclePath driven =
          vehiclePath(l_, lanePaths_[drivers_[i].route], p.out, p.vehicle.width() / 2, placer_.worldFromTown);
      const auto movement = std::make_shared<const Movement>(driven.path, travelled[i], kInterval);
      placer_.putMoving(p.vehicle.mesh, p.name, movement);
      if (p.rider) placer_.putMoving(p.rider->mesh, "rider of " + p.name, movement);
    }
  }

 private:
  // The models and the name of a vehicle. Participants and drivers have the same indices.
  struct Participant {
    Model vehicle;
    std::optional<Model> rider;
    double out = 0;  // m to the right of the middle of the rightmost lane
    std::string name;
  };

  const Road& road(std::uint32_t r) const { return l_.roads()[r]; }
  // inwards() returns the number of side road r's lane towards, outwards() away from the main road, whose lane is 0.
  static std::uint32_t inwards(std::uint32_t r) { return 2 * r; }
  static std::uint32_t outwards(std::uint32_t r) { return 2 * r + 1; }

  // Adds a route without legs and stops, `out` m to the right of the rightmost lane's middle. Returns its index.
  std::uint32_t addRoute(const LanePath& lanePath, double out = 0) {
    lanePaths_.push_back(lanePath);
    paths_.push_back(vehiclePath(l_, lanePath, out, 0, placer_.worldFromTown));
    const Path& path = *paths_.back().path;
    std::vector<double> curvature;
    for (const double d : models::steps(0, path.length(), kLimitStep)) curvature.push_back(path.curvature(d, 4));
    routes_.push_back({.length = path.length(), .limit = inBends(curvature, fastest_)});
    return static_cast<std::uint32_t>(routes_.size() - 1);
  }

  // Returns the first position (m along road `r`) from `from` to `to` where an object blocks the lane; nullopt: none.
  std::optional<double> firstObstacle(std::uint32_t r, double from, double to) const {
    const double direction = to >= from ? 1 : -1;
    const double lateral = road(r).oneWay() ? 0 : std::max(road(r).laneMiddle(), 0.9 + kMiddle);
    for (const double travelled : models::steps(0, std::abs(to - from), 1.5)) {
      const double along = from + direction * travelled;
      const Spot spot = besideRoad(road(r), along, -direction * lateral);
      if (!placer_.occupancy.isFree({spot.at, 0.75, 0.9, spot.yaw})) return along;
    }
    return std::nullopt;
  }

  // Adds the route through the town: the complete main road, against its line, with stop lines at obstacles and lights.
  void addThrough() {
    constexpr double kBeforeObstacle = 2;  // m
    constexpr double kNextObstacle = 26;   // m from the start of an obstacle to where the search for the next starts
    const double length = main_.length();
    const std::uint32_t route = addRoute({{{0, length, 0}}, kUpstream, kBeyond});
    Route& through = routes_[route];
    through.legs = {{.lane = 0, .from = 0, .to = through.length}};
    std::optional<double> obstacle = firstObstacle(0, length, 0);
    while (obstacle) {
      through.stops.push_back({.at = paths_[route].distanceAt(0, *obstacle) - kBeforeObstacle});
      obstacle = *obstacle > kNextObstacle ? firstObstacle(0, *obstacle - kNextObstacle, 0) : std::nullopt;
    }
    addLights(route, &Placer::Light::stopAgainstLine);
  }

  // Adds stop lines at the main road's lights. `position`: stopAgainstLine or stopWithLine.
  void addLights(std::uint32_t route, double Placer::Light::*position) {
    for (const Placer::Light& light : placer_.lights) {
      routes_[route].stops.push_back({.at = paths_[route].distanceAt(0, light.*position),
                                      .rule = TrafficLight{light.kPeriod, light.kRed, light.offset}});
    }
  }

  // Adds the routes of the passing lanes, in both directions, and their vehicles. Vehicles do not change lanes. There
  // are none on the ego vehicle's lane.
  void addPassing() {
    if (main_.oneWay()) return;
    const double length = main_.length();
    for (int lane = 1; lane < main_.section.lanes; ++lane) {
      for (const bool along : {false, true}) {
        if (along && lane == egoLine(l_).lane) continue;
        const LanePath lanePath{{{0, along ? 0 : length, along ? length : 0}}, kUpstream, kBeyond};
        const std::uint32_t laneNumber = kPassing + 2 * static_cast<std::uint32_t>(lane) + (along ? 1 : 0);
        const double out = -lane * main_.section.laneWidth();
        const std::uint32_t route = addRoute(lanePath, out);
        routes_[route].legs = {{.lane = laneNumber, .from = 0, .to = routes_[route].length}};
        addLights(route, along ? &Placer::Light::stopWithLine : &Placer::Light::stopAgainstLine);
        Draw draw(l_.seed, Kind::PassingTraffic, laneNumber);
        addPassingVehicles(draw, route, out);
      }
    }
  }

  // Adds the routes into and out of a side road and their vehicles, unless its lanes are short or the ego vehicle uses
  // it. At the left of the main road, vehicles turn between the roads without crossing the ego vehicle's lane; at the
  // right they stop at the ends of the side road's lanes.
  void addSideRoad(const Road& side) {
    constexpr double kLeastLanes = 20;  // m
    const std::uint32_t r = side.number;
    const double end = laneEnd(side);
    const double start = laneStart(l_);
    if (!side.joins || end < start + kLeastLanes || egoRoads(l_).has(side)) return;
    const bool turns = side.joinsLeft && main_.against;
    std::optional<std::uint32_t> outRoute, inRoute;  // indices of the routes away from and towards the main road
    if (side.along && !firstObstacle(r, start, end)) {
      outRoute = addRoute({{{r, start, end}}});
      const double length = routes_[*outRoute].length;
      routes_[*outRoute].legs = {{.lane = outwards(r), .from = 0, .to = length}};
      routes_[*outRoute].stops = {{.at = length - kBeforeEnd}};
      if (turns) addTurnInto(side);
    }
    if (side.against && !firstObstacle(r, end, start)) inRoute = turns ? addTurnOutOf(side) : addUpToStopLine(side);
    addSideVehicles(r, inRoute, outRoute, end - start);
  }

  // Adds the route from the main road into a side road. Up to the turn, the route has the first route's lane and stops.
  void addTurnInto(const Road& side) {
    constexpr double kSeenBefore = 4;  // m; turning vehicles count as on the side lane this far before its start
    const double turnAlong = *side.joins + turnStart(side);  // m along the main road
    const std::uint32_t index =
        addRoute({.intervals = {{0, main_.length(), turnAlong}, {side.number, laneStart(l_), laneEnd(side)}},
                  .hiddenBefore = kUpstream});
    Route& route = routes_[index];
    const double laneBegin = paths_[index].distanceAt(side.number, laneStart(l_));  // m along the route
    route.legs = {
        {.lane = 0, .from = 0, .to = laneBegin},
        {.lane = outwards(side.number), .from = laneBegin - kSeenBefore, .to = route.length, .shift = -laneBegin}};
    route.stops = {{.at = route.length - kBeforeEnd}};
    for (const StopLine& s : routes_.front().stops) {
      if (s.at < paths_[index].distanceAt(0, turnAlong)) route.stops.push_back(s);
    }
    turns_.push_back(index);
  }

  // Adds the route along a side road to its stop line, where vehicles wait forever. Returns the route's index.
  std::uint32_t addUpToStopLine(const Road& side) {
    const std::uint32_t index = addRoute({{{side.number, laneEnd(side), stopLineOfSideRoad(l_)}}});
    Route& route = routes_[index];
    route.legs = {{.lane = inwards(side.number), .from = 0, .to = route.length}};
    route.stops = {{.at = paths_[index].distanceAt(side.number, stopLineOfSideRoad(l_)) - kBeforeEnd}};
    return index;
  }

  // Adds the route from a side road into the main road, with a give-way line. Returns the route's index.
  std::uint32_t addTurnOutOf(const Road& side) {
    constexpr double kLooksBack = 50, kLooksAhead = 14;  // m before and behind the merge that must be free
    constexpr double kLeaves = 6, kEnters = 1;  // m behind the stop line: end of the side lane, start of lane 0
    const double mergeAlong = *side.joins - turnStart(side);  // m along the main road
    const std::uint32_t r = side.number;
    const std::uint32_t index =
        addRoute({{{r, laneEnd(side), stopLineOfSideRoad(l_)}, {0, mergeAlong, 0}}, 0, kBeyond});
    Route& route = routes_[index];
    const double line = paths_[index].distanceAt(r, stopLineOfSideRoad(l_));
    const double merge = paths_[index].distanceAt(0, mergeAlong);          // m along this route
    const double throughMerge = paths_.front().distanceAt(0, mergeAlong);  // m along the route through the town
    const double shift = throughMerge - merge;
    route.legs = {{.lane = inwards(r), .from = 0, .to = line + kLeaves},
                  {.lane = 0, .from = line + kEnters, .to = route.length, .shift = shift}};
    const GiveWay toMainRoad{.lane = 0, .from = throughMerge - kLooksBack, .to = throughMerge + kLooksAhead};
    route.stops = {{.at = line, .rule = toMainRoad}};
    for (const StopLine& s : routes_.front().stops) {
      if (s.at > throughMerge) route.stops.push_back({.at = s.at + merge - throughMerge, .rule = s.rule});
    }
    return index;
  }

  // Adds vehicles to a side road's two routes, each of which may be missing. `length`: length of the lanes (m).
  void addSideVehicles(std::uint32_t r, const std::optional<std::uint32_t>& inRoute,
                       const std::optional<std::uint32_t>& outRoute, double length) {
    constexpr double kApart = 14;  // m between the middles of two vehicles
    Draw draw(l_.seed, Kind::SideTraffic, r);
    const int count = static_cast<int>(l_.character.traffic * 0.4 * length / 100 + draw.next());
    std::vector<std::pair<std::uint32_t, double>> starts;  // (route, m along the route)
    for (int k = 0; k < count; ++k) {
      const std::optional<std::uint32_t>& route = draw.chance(0.5) ? inRoute : outRoute;
      const double along = draw.in(4, std::max(5.0, length - 12));
      const double startTime = draw.chance(0.5) ? draw.in(0, 40) : kAlways;
      const Model& car = anyCar(placer_, draw);
      const double out = draw.in(-0.15, 0.15);
      const auto isNear = [&](const auto& s) { return s.first == *route && std::abs(s.second - along) < kApart; };
      if (!route || std::ranges::any_of(starts, isNear)) continue;
      starts.emplace_back(*route, along);
      addDriver(*route, along, car, std::nullopt, draw.in(6, 10), out, startTime);
    }
  }

  // Adds the vehicles that drive through the town or turn off. Distances between vehicles at the start are at least
  // kStartGap plus the distance driven in 1 s. The first cyclistCount() vehicles in the built-up part are cyclists.
  void drawThrough() {
    if (!main_.against) return;
    constexpr double kHeavyShare = 0.27, kBusShare = 0.16, kMotorcycleShare = 0.2, kTurnShare = 0.25;
    Draw draw(l_.seed, Kind::Traffic);
    const double density = l_.character.traffic / 100;  // vehicles per m
    const double end = routes_.front().length - kBeyond;
    int missingCyclists = cyclistCount();
    const double builtFrom = paths_.front().distanceAt(0, l_.mainTo);
    const double builtTo = paths_.front().distanceAt(0, l_.mainFrom);
    double along = draw.in(0, 30);
    while (along < end) {
      const double speed = fastest_ * draw.in(0.85, 1.1);
      const double pick = draw.next();
      const double out = draw.in(-0.2, 0.2);
      if (missingCyclists > 0 && along > builtFrom && along < builtTo) {
        --missingCyclists;
        addCyclist(draw, along);
      } else if (density > 0 && pick > 1 - kMotorcycleShare) {
        addMotorcyclist(draw, 0, along, speed, out);
        along += kStartGap + speed;
        continue;
      } else if (density > 0) {
        const bool heavy = pick < kHeavyShare && main_.section.laneWidth() > kHeavyLane;
        const Model& m = !heavy ? anyCar(placer_, draw) : pick < kBusShare ? busOf(placer_) : anyTruck(placer_, draw);
        const bool turns = !heavy && !turns_.empty() && draw.chance(kTurnShare);
        const std::uint32_t route = turns ? draw.itemOf(turns_) : 0;
        const bool beforeTurn = along < routes_[route].legs.front().to - 30;
        // Lorries and buses drive in the middle of the lane, since they need its full width in bends.
        addDriver(beforeTurn ? route : 0, along, m, std::nullopt, speed, heavy ? 0 : out, kAlways);
      }
      const double least = kStartGap + speed;
      const double mean = density > 0 ? std::max(1 / density - least, 8.0) : 40;
      along += least - mean * std::log(draw.next());
    }
  }

  // Adds the vehicles of a passing lane, which are faster than those on the rightmost lane. `out`: see Participant.
  void addPassingVehicles(Draw& draw, std::uint32_t route, double out) {
    const double per100m = l_.character.traffic;
    const double end = routes_[route].length - kBeyond;
    double along = draw.in(0, 30);
    while (per100m > 0 && along < end) {
      const double speed = 1.1 * fastest_ * draw.in(0.9, 1.1);
      const double vehicleOut = out + draw.in(-0.2, 0.2);
      const bool heavy = draw.chance(0.08) && main_.section.laneWidth() > kHeavyLane;
      if (draw.chance(0.2)) {
        addMotorcyclist(draw, route, along, speed, vehicleOut);
      } else {
        const Model& m = heavy ? anyTruck(placer_, draw) : anyCar(placer_, draw);
        addDriver(route, along, m, std::nullopt, speed, vehicleOut, kAlways);
      }
      const double least = kStartGap + speed;
      along += least - std::max(100 / per100m - least, 8.0) * std::log(draw.next());
    }
  }

  // Returns the number of cyclists on the main road.
  int cyclistCount() const {
    if (l_.parameters.people <= 0 || l_.character.motorway) return 0;
    Draw draw(l_.seed, Kind::RoadCyclists);
    const double length = l_.mainTo - l_.mainFrom;
    return std::max(1, static_cast<int>(0.7 * l_.character.people * length / 100 + draw.next()));
  }

  // Returns one of `Count` models at random. `make` builds a model when it is first needed.
  template <std::size_t Count, class Make>
  const models::Ridden& anyRidden(std::array<std::optional<models::Ridden>, Count>& built, Draw& draw,
                                  const Make& make) {
    const int form = draw.below(static_cast<int>(Count));
    std::optional<models::Ridden>& ridden = built[static_cast<std::size_t>(form)];
    if (!ridden) ridden = make(placer_.builder, l_.seed, form);
    return *ridden;
  }

  void addCyclist(Draw& draw, double along) {
    constexpr double kBesideParked = 1;  // m from the lane's middle, where cyclists pass parked cars
    const auto& [bicycle, rider] = anyRidden(cyclists_, draw, models::makeCyclist);
    const double speed = draw.in(3.5, 6);
    const double out = std::min(main_.section.laneWidth() / 2 - 0.6, kBesideParked);
    addDriver(0, along, bicycle, rider, speed, out, kAlways, "cyclist's bicycle");
  }

  void addMotorcyclist(Draw& draw, std::uint32_t route, double along, double speed, double out) {
    const auto& [motorcycle, rider] = anyRidden(motorcyclists_, draw, models::makeMotorcyclist);
    addDriver(route, along, motorcycle, rider, speed, out, kAlways, "traffic on a motorcycle");
  }

  // Adds a vehicle that starts `along` m along the route and does not move before `startTime` (s). Adds nothing if a
  // stop line without a light (for giving way or at an obstacle) is less than kBeforeLine ahead or kBehindLine behind.
  // The vehicle's name is `namePrefix` and a number.
  void addDriver(std::uint32_t route, double along, const Model& vehicle, const std::optional<Model>& rider,
                 double speed, double out, double startTime, const std::string& namePrefix = "traffic") {
    constexpr double kBeforeLine = 14, kBehindLine = 26;  // m
    const bool nearLine = std::ranges::any_of(routes_[route].stops, [&](const StopLine& s) {
      return !s.hasLight() && along > s.at - kBeforeLine && along < s.at + kBehindLine;
    });
    if (nearLine) return;
    drivers_.push_back({route, along, vehicle.length(), speed, startTime});
    participants_.push_back({vehicle, rider, out, fmt::format("{} {}", namePrefix, ++numbers_[namePrefix])});
  }

  Placer& placer_;
  const Layout& l_;
  const Road& main_;
  double fastest_;                   // m/s, speed limit in the town
  std::vector<LanePath> lanePaths_;  // by route
  std::vector<VehiclePath> paths_;   // by route
  std::vector<Route> routes_;
  std::vector<std::uint32_t> turns_;  // indices of routes that turn off the main road
  std::vector<Driver> drivers_;
  std::vector<Participant> participants_;
  std::map<std::string, int> numbers_;                                     // last number that was used, by namePrefix
  std::array<std::optional<models::Ridden>, kRoadCyclistForms> cyclists_;  // built when they are first needed
  std::array<std::optional<models::Ridden>, 2> motorcyclists_;
};

}  // namespace

void placeTraffic(Placer& placer) {
  Traffic(placer).place();
}

}  // namespace scanmill::town
