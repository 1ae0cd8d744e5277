#pragma once

// Simulates over time how vehicles follow one another along lanes, stop at traffic lights and give way.

#include <cstdint>
#include <variant>
#include <vector>

namespace scanmill::town {

// The part of a route on one lane; routes can share lanes. Distance along the lane: distance along the route + shift.
struct Leg {
  std::uint32_t lane = 0;
  double from = 0, to = 0;  // m along the route, ends of this part
  double shift = 0;
};

// The rule AlwaysClosed, TrafficLight or GiveWay says when a stop line is closed.
struct AlwaysClosed {};
// The light is red during the first `red` seconds of each period of `period` seconds; a period begins at `offset` (s).
struct TrafficLight {
  double period = 0, red = 0, offset = 0;
};
// The stop line is closed while a vehicle on the lane `lane` is between `from` and `to` (m along the lane).
struct GiveWay {
  std::uint32_t lane = 0;
  double from = 0, to = 0;
};

// A line at which vehicles stop while the line is closed.
struct StopLine {
  double at = 0;  // m along the route
  std::variant<AlwaysClosed, TrafficLight, GiveWay> rule{};
  bool hasLight() const { return std::holds_alternative<TrafficLight>(rule); }
};

struct Route {
  double length = 0;  // m; vehicles that have reached the end are ignored
  std::vector<Leg> legs{};
  std::vector<StopLine> stops{};
  std::vector<double> limit{};  // speed limits (m/s) at 0, kLimitStep, ... m along the route: see inBends()
};

constexpr double kLimitStep = 2;  // m between the values of Route::limit

struct Driver {
  std::uint32_t route = 0;
  double at = 0;         // m along the route: the vehicle's middle at the start of the simulation
  double length = 4;     // length of the vehicle, m
  double speed = 10;     // desired speed, m/s
  double starts = -1e9;  // s; the vehicle does not move before this time
};

// The intelligent driver model: Treiber, Hennecke, Helbing, "Congested traffic states in empirical observations and
// microscopic simulations", Physical Review E 62 (2000), equations (3) and (4).
struct DriverModel {
  double acceleration = 1.4;  // m/s^2, maximum acceleration
  double braking = 2;         // m/s^2, comfortable deceleration
  double headway = 1.4;       // s, time gap to the vehicle in front
  double gap = 2;             // m between stationary vehicles
};

// Returns the speed limits (m/s) at 0, kLimitStep, ... m along a route: at most `fastest`, and low enough
// that lateral acceleration and braking at bends are comfortable. `curvature`: 1/m, at the same distances.
std::vector<double> inBends(const std::vector<double>& curvature, double fastest);

// Returns, for each driver, the distances (m) along the driver's route at the times 0, interval, ... up to `duration`
// (s). The simulation starts `warmUp` seconds before time 0. Vehicles neither drive backwards nor collide on a lane.
std::vector<std::vector<double>> drive(const std::vector<Route>& routes, const std::vector<Driver>& drivers,
                                       double warmUp, double duration, double interval);

}  // namespace scanmill::town
