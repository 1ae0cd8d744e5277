#include "town/flow.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scanmill::town {
namespace {

constexpr double kSideways = 2;     // m/s^2, largest lateral acceleration in bends
constexpr double kSlowing = 1.2;    // m/s^2, deceleration before bends
constexpr double kHardest = 8;      // m/s^2, largest deceleration of a vehicle
constexpr double kRunsAmber = 3.5;  // m/s^2; drivers who would have to brake harder do not stop at red
constexpr double kSight = 120;      // m, how far drivers look ahead
constexpr double kNone = std::numeric_limits<double>::infinity();

constexpr DriverModel kModel;

struct State {
  double at = 0;     // m along the vehicle's route
  double speed = 0;  // m/s
};

// The states of all vehicles. step() advances them in time.
class Flow {
 public:
  // `begin`: time (s) of the start of the simulation.
  Flow(const std::vector<Route>& routes, const std::vector<Driver>& drivers, double begin)
      : routes_(routes), drivers_(drivers) {
    for (const Driver& d : drivers) states_.push_back({d.at, d.starts <= begin ? firstSpeed(d) : 0});
  }

  // Advances all vehicles from `time` by `dt` (s). The accelerations follow from the states at `time`.
  void step(double time, double dt) {
    std::vector<double> accelerations;
    for (std::size_t i = 0; i < drivers_.size(); ++i) accelerations.push_back(acceleration(i, time));
    for (std::size_t i = 0; i < drivers_.size(); ++i) {
      State& s = states_[i];
      s.speed = std::max(0.0, s.speed + accelerations[i] * dt);
      s.at = std::min(s.at + s.speed * dt, routeOf(i).length);
    }
  }

  double at(std::size_t driver) const { return states_[driver].at; }

 private:
  const Route& routeOf(std::size_t i) const { return routes_[drivers_[i].route]; }
  bool gone(std::size_t i) const { return states_[i].at >= routeOf(i).length; }

  double limitAt(const Driver& d, double at) const {
    const std::vector<double>& limit = routes_[d.route].limit;
    if (limit.empty()) return d.speed;
    const double cell = std::clamp(at / kLimitStep, 0.0, static_cast<double>(limit.size() - 1));
    return std::min(d.speed, limit[static_cast<std::size_t>(cell)]);
  }

  // Returns a vehicle's initial speed (m/s): at most the limit, and low enough to stop at stop lines without a light.
  double firstSpeed(const Driver& d) const {
    double speed = limitAt(d, d.at);
    for (const StopLine& stop : routes_[d.route].stops) {
      const double gap = stop.at - d.at - d.length / 2;
      if (!stop.hasLight() && gap >= 0) speed = std::min(speed, std::sqrt(2 * kModel.braking * gap));
    }
    return speed;
  }

  // Returns the acceleration (m/s^2) by equations (3) and (4) of the driver model. `gap`: distance (m) to the vehicle
  // in front, or kNone without such a vehicle. `approach`: own speed minus the speed of the vehicle in front (m/s).
  double following(double speed, double desiredSpeed, double gap, double approach) const {
    const double freeTerm = std::pow(speed / desiredSpeed, 4);
    if (gap == kNone) return std::max(-kModel.braking, kModel.acceleration * (1 - freeTerm));
    const double dynamicGap =
        speed * kModel.headway + speed * approach / (2 * std::sqrt(kModel.acceleration * kModel.braking));
    const double desiredGap = kModel.gap + std::max(0.0, dynamicGap);
    const double gapRatio = desiredGap / std::max(gap, 0.01);
    return std::max(-kHardest, kModel.acceleration * (1 - freeTerm - gapRatio * gapRatio));
  }

  // Returns vehicle `i`'s acceleration (m/s^2): the least for the speed limit, vehicles in front and closed stop lines.
  double acceleration(std::size_t i, double time) const {
    const Driver& d = drivers_[i];
    const State& s = states_[i];
    if (gone(i) || time < d.starts) return 0;
    const double desiredSpeed = limitAt(d, s.at);
    double least = following(s.speed, desiredSpeed, kNone, 0);
    for (const Leg& leg : routeOf(i).legs) {
      if (leg.to < s.at || leg.from > s.at + kSight) continue;
      forVehiclesOn(leg.lane, [&](std::size_t j, double alongLane) {
        const double position = alongLane - leg.shift;  // of vehicle j, m along the route of vehicle i
        const bool ahead = position > s.at || (position == s.at && j < i);
        if (j == i || !ahead || position > s.at + kSight || position < leg.from || position > leg.to) return;
        const double gap = position - s.at - (d.length + drivers_[j].length) / 2;
        least = std::min(least, following(s.speed, desiredSpeed, gap, s.speed - states_[j].speed));
      });
    }
    for (const StopLine& stop : routeOf(i).stops) {
      const double gap = stop.at - s.at - d.length / 2;
      if (gap < 0 || gap > kSight || !isClosed(stop, time)) continue;
      if (stop.hasLight() && s.speed * s.speed > 2 * kRunsAmber * gap) continue;
      // Vehicles stop about 0.5 m before a line, not kModel.gap as behind another vehicle.
      least = std::min(least, following(s.speed, desiredSpeed, gap + kModel.gap - 0.5, s.speed));
    }
    return least;
  }

  // Calls visit(vehicle, position) for each vehicle on a lane. `vehicle`: its index; `position`: m along the lane.
  template <class Visit>
  void forVehiclesOn(std::uint32_t lane, const Visit& visit) const {
    for (std::size_t j = 0; j < drivers_.size(); ++j) {
      if (gone(j)) continue;
      for (const Leg& leg : routeOf(j).legs) {
        const bool onLeg = leg.lane == lane && states_[j].at >= leg.from && states_[j].at <= leg.to;
        if (onLeg) visit(j, states_[j].at + leg.shift);
      }
    }
  }

  bool isClosed(const StopLine& stop, double time) const {
    if (const auto* const light = std::get_if<TrafficLight>(&stop.rule)) {
      const double phase = (time - light->offset) / light->period;
      return (phase - std::floor(phase)) * light->period < light->red;
    }
    const auto* const giveWay = std::get_if<GiveWay>(&stop.rule);
    if (giveWay == nullptr) return true;
    bool occupied = false;
    forVehiclesOn(giveWay->lane, [&](std::size_t, double position) {
      occupied |= position > giveWay->from && position < giveWay->to;
    });
    return occupied;
  }

  const std::vector<Route>& routes_;
  const std::vector<Driver>& drivers_;
  std::vector<State> states_;
};

}  // namespace

std::vector<double> inBends(const std::vector<double>& curvature, double fastest) {
  std::vector<double> limit;
  limit.reserve(curvature.size());
  for (const double c : curvature) {
    limit.push_back(std::min(fastest, std::sqrt(kSideways / std::max(std::abs(c), 1e-6))));
  }
  for (std::size_t i = limit.size(); i-- > 1;) {
    limit[i - 1] = std::min(limit[i - 1], std::sqrt(limit[i] * limit[i] + 2 * kSlowing * kLimitStep));
  }
  return limit;
}

std::vector<std::vector<double>> drive(const std::vector<Route>& routes, const std::vector<Driver>& drivers,
                                       double warmUp, double duration, double interval) {
  Flow flow(routes, drivers, -warmUp);
  const auto before = static_cast<int>(std::ceil(warmUp / interval));
  const auto steps = static_cast<int>(std::ceil(duration / interval));
  std::vector<std::vector<double>> travelled(drivers.size());
  for (int k = -before; k <= steps; ++k) {
    if (k >= 0) {
      for (std::size_t i = 0; i < drivers.size(); ++i) travelled[i].push_back(flow.at(i));
    }
    flow.step(k * interval, interval);
  }
  return travelled;
}

}  // namespace scanmill::town
