#include "sensors/speed_profile.h"

#include <algorithm>
#include <cmath>

#include "base/path.h"
#include "base/random.h"
#include "config/fields.h"

namespace scanmill {

namespace {

constexpr double kStep = 0.25;   // m, largest distance between the positions where the speed is computed
constexpr double kReach = 2;     // m; the curvature is measured from this far before to this far behind a position
constexpr double kCrawl = 1e-3;  // m/s; least mean speed between two places, so that a vehicle that starts or stops
                                 // takes a finite time

}  // namespace

SpeedProfile::SpeedProfile(double length, double speed) : nodes_{{0, 0, speed}, {length / speed, length, speed}} {}

SpeedProfile::SpeedProfile(const Path& path, double speed, double acceleration, const std::vector<DriveStop>& stops) {
  // `places`: positions on the path (m), including the stops and both ends. `fastest`: largest speed at each position.
  std::vector<double> places;
  const auto pieces = static_cast<int>(std::ceil(path.length() / kStep));
  for (int k = 0; k <= pieces; ++k) places.push_back(path.length() * k / pieces);
  for (const DriveStop& stop : stops) places.push_back(stop.at);
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  std::vector<double> fastest;
  fastest.reserve(places.size());
  for (const double at : places) {
    fastest.push_back(std::min(speed, std::sqrt(kSideways / std::max(std::abs(path.curvature(at, kReach)), 1e-9))));
  }
  fastest.front() = fastest.back() = 0;
  for (const DriveStop& stop : stops) {
    const auto at = std::lower_bound(places.begin(), places.end(), stop.at) - places.begin();
    fastest[static_cast<std::size_t>(at)] = 0;
  }
  const auto reached = [&](double from, double over) { return std::sqrt(from * from + 2 * acceleration * over); };
  for (std::size_t i = 1; i < places.size(); ++i) {
    fastest[i] = std::min(fastest[i], reached(fastest[i - 1], places[i] - places[i - 1]));
  }
  for (std::size_t i = places.size() - 1; i-- > 0;) {
    fastest[i] = std::min(fastest[i], reached(fastest[i + 1], places[i + 1] - places[i]));
  }
  nodes_.push_back({0, 0, 0});
  auto stop = stops.begin();
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i > 0) {
      const double mean = std::max((fastest[i] + fastest[i - 1]) / 2, kCrawl);
      nodes_.push_back({nodes_.back().time + (places[i] - places[i - 1]) / mean, places[i], fastest[i]});
    }
    for (; stop != stops.end() && stop->at <= places[i]; ++stop) {
      nodes_.push_back({nodes_.back().time + stop->wait, places[i], 0});
    }
  }
}

double SpeedProfile::distance(double time) const {
  if (time <= 0) return 0;
  if (time >= duration()) return nodes_.back().distance;
  const auto b = std::ranges::upper_bound(nodes_, time, {}, &Node::time);
  const auto a = b - 1;
  const double t = time - a->time;
  const double acceleration = (b->speed - a->speed) / (b->time - a->time);
  return std::clamp(a->distance + t * (a->speed + acceleration * t / 2), a->distance, b->distance);
}

double SpeedProfile::speed(double time) const {
  if (time <= 0) return nodes_.front().speed;
  if (time >= duration()) return nodes_.back().speed;
  const auto b = std::ranges::upper_bound(nodes_, time, {}, &Node::time);
  const auto a = b - 1;
  return a->speed + (b->speed - a->speed) * (time - a->time) / (b->time - a->time);
}

double SpeedProfile::timeAt(double distance) const {
  const auto next = std::ranges::lower_bound(nodes_, distance, {}, &Node::distance);
  if (next == nodes_.begin()) return 0;
  if (next == nodes_.end()) return duration();
  const Node& a = *(next - 1);
  const Node& b = *next;
  // Solve v t + a t^2 / 2 = s for t, in a form that is exact for small a too.
  const double acceleration = (b.speed - a.speed) / (b.time - a.time);
  const double driven = distance - a.distance;  // since node a
  const double now = std::sqrt(std::max(0.0, a.speed * a.speed + 2 * acceleration * driven));
  return std::min(a.time + (a.speed + now > 0 ? 2 * driven / (a.speed + now) : b.time - a.time), b.time);
}

Sway::Sway(const Value& value, std::uint64_t seed) {
  Fields f(value, "sway");
  f.also({"roll_deg", "pitch_deg", "heave_m"}).finish();
  roll_ = radians(f.number("roll_deg", {0, 10}, 0));
  pitch_ = radians(f.number("pitch_deg", {0, 10}, 0));
  heave_ = f.number("heave_m", {0, 1}, 0);
  constexpr double kSlowest = 0.6;  // Hz, lowest frequency of the sinusoids
  constexpr double kQuickest = 2;
  for (std::uint32_t axis = 0; axis < waves_.size(); ++axis) {
    for (std::uint32_t k = 0; k < kWaves; ++k) {
      const std::uint32_t wave = axis * static_cast<std::uint32_t>(kWaves) + k;
      const RandomBlock block = randomBlock({.seed = seed, .beam = wave, .purpose = Purpose::Sway});
      waves_[axis][k] = {2 * kPi * (kSlowest + (kQuickest - kSlowest) * (k + uniform(block[0])) / kWaves),
                         2 * kPi * uniform(block[1])};
    }
  }
}

// Returns a sum of sinusoids at a time (s), scaled so that its variance over time is 1.
double Sway::sum(const Waves& waves, double time) {
  double all = 0;
  for (const Wave& w : waves) all += std::sin(w.frequency * time + w.phase);
  return all * std::sqrt(2.0 / kWaves);
}

Pose Sway::at(double time, double part) const {
  if (roll_ == 0 && pitch_ == 0 && heave_ == 0) return {};
  return {fromYawPitchRoll(0, part * pitch_ * sum(waves_[1], time), part * roll_ * sum(waves_[0], time)),
          {0, 0, part * heave_ * sum(waves_[2], time)}};
}

}  // namespace scanmill
