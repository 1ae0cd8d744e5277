#pragma once

// How vehicles follow one another along lanes, stop at lights and give way, over time.

#include <cstdint>
#include <vector>

namespace scanmill::town {

// The part of a route that lies on a lane, which routes share: the distance d along the route is d + shift along the
// lane (m).
struct Leg {
  std::uint32_t lane = 0;
  double from = 0, to = 0;  // along the route
  double shift = 0;
};

// A line that vehicles stop at, while it is closed.
struct StopLine {
  double at = 0;  // along the route, m
  // Red for the first `red` of every `period` seconds, counted from `offset`; no period: closed for good, unless it is
  // one to give way at.
  double period = 0, red = 0, offset = 0;
  // Closed while somebody is on this stretch of a lane.
  bool givesWay = false;
  std::uint32_t lane = 0;
  double from = 0, to = 0;
};

struct Route {
  double length = 0;  // m; who has come to its end no longer counts
  std::vector<Leg> legs;
  std::vector<StopLine> stops;
  std::vector<double> limit;  // m/s, at 0, kLimitStep, ... m along it: see inBends()
};

constexpr double kLimitStep = 2;  // m

struct Driver {
  std::uint32_t route = 0;
  double at = 0;         // of the vehicle's middle along the route when the simulation begins, m
  double length = 4;     // of the vehicle, m
  double speed = 10;     // that it would like to drive at, m/s
  double starts = -1e9;  // s; until then it stands
};

// The intelligent driver model: Treiber, Hennecke, Helbing, "Congested traffic states in empirical observations and
// microscopic simulations", Physical Review E 62 (2000), equations (3) and (4).
struct DriverModel {
  double acceleration = 1.4;  // m/s^2
  double braking = 2;         // m/s^2, comfortable
  double headway = 1.4;       // s
  double gap = 2;             // m, between vehicles that stand
};

// What the accelerations to the side and of braking leave of a speed: `curvature` (1/m) is that of the route at 0,
// kLimitStep, ... m along it.
std::vector<double> inBends(const std::vector<double>& curvature, double fastest);

// How far each driver has come along its route (m) at the times 0, interval, ... up to `duration` (s), having driven
// for `warmUp` seconds before that. Nobody drives backwards or into another on its lane.
std::vector<std::vector<double>> drive(const std::vector<Route>& routes, const std::vector<Driver>& drivers,
                                       double warmUp, double duration, double interval);

}  // namespace scanmill::town
