#include <algorithm>
#include <cmath>

#include "base/path.h"
#include "base/random.h"
#include "config/fields.h"
#include "sensors/trajectory.h"

namespace scanmill {

namespace {

constexpr double kStep = 0.25;   // m, largest distance between the positions where the speed is computed
constexpr double kReach = 2;     // m; the curvature is measured over this length before and after a position
constexpr double kCrawl = 1e-3;  // m/s; least mean speed between two positions, so that a vehicle that starts or stops
                                 // takes a finite time

}  // namespace

SpeedProfile::SpeedProfile(double length, double speed) : nodes_{{0, 0, speed}, {length / speed, length, speed}} {}

SpeedProfile::SpeedProfile(const Path& path, double speed, double acceleration, const std::vector<DriveStop>& stops) {
  std::vector<double> positions;  // m along the path, ascending; with the stops and both ends
  const auto steps = static_cast<int>(std::ceil(path.length() / kStep));
  for (int k = 0; k <= steps; ++k) positions.push_back(path.length() * k / steps);
  for (const DriveStop& stop : stops) positions.push_back(stop.position);
  std::ranges::sort(positions);
  positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
  // The speed is first limited by curvature, ends and stops, then by accelerating from the previous position and by
  // braking to the next position.
  std::vector<double> speeds;  // m/s, by position
  speeds.reserve(positions.size());
  for (const double position : positions) {
    const double curvature = std::max(std::abs(path.curvature(position, kReach)), 1e-9);
    speeds.push_back(std::min(speed, std::sqrt(kSideways / curvature)));
  }
  speeds.front() = speeds.back() = 0;
  for (const DriveStop& stop : stops) {
    const auto index = std::ranges::lower_bound(positions, stop.position) - positions.begin();
    speeds[static_cast<std::size_t>(index)] = 0;
  }
  const auto speedAfter = [&](double start, double metres) {
    return std::sqrt(start * start + 2 * acceleration * metres);
  };
  for (std::size_t i = 1; i < positions.size(); ++i) {
    speeds[i] = std::min(speeds[i], speedAfter(speeds[i - 1], positions[i] - positions[i - 1]));
  }
  for (std::size_t i = positions.size() - 1; i-- > 0;) {
    speeds[i] = std::min(speeds[i], speedAfter(speeds[i + 1], positions[i + 1] - positions[i]));
  }
  nodes_.push_back({0, 0, 0});
  auto stop = stops.begin();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (i > 0) {
      const double meanSpeed = std::max((speeds[i] + speeds[i - 1]) / 2, kCrawl);
      const double time = nodes_.back().time + (positions[i] - positions[i - 1]) / meanSpeed;
      nodes_.push_back({.time = time, .distance = positions[i], .speed = speeds[i]});
    }
    for (; stop != stops.end() && stop->position <= positions[i]; ++stop) {
      nodes_.push_back({.time = nodes_.back().time + stop->duration, .distance = positions[i], .speed = 0});
    }
  }
}

SpeedProfile::Node SpeedProfile::stateAt(double time) const {
  if (time <= 0) return nodes_.front();
  if (time >= duration()) return nodes_.back();
  const auto b = std::ranges::upper_bound(nodes_, time, {}, &Node::time);
  const auto a = b - 1;
  const double t = time - a->time;
  const double acceleration = (b->speed - a->speed) / (b->time - a->time);
  return {.time = time,
          .distance = std::clamp(a->distance + t * (a->speed + acceleration * t / 2), a->distance, b->distance),
          .speed = a->speed + (b->speed - a->speed) * t / (b->time - a->time)};
}

double SpeedProfile::timeAt(double distance) const {
  const auto next = std::ranges::lower_bound(nodes_, distance, {}, &Node::distance);
  if (next == nodes_.begin()) return 0;
  if (next == nodes_.end()) return duration();
  const Node& a = *(next - 1);
  const Node& b = *next;
  // Solve a.speed * t + acceleration * t^2 / 2 = driven for t, in a form that is exact for small accelerations too.
  const double acceleration = (b.speed - a.speed) / (b.time - a.time);
  const double driven = distance - a.distance;  // m since node a
  const double speed = std::sqrt(std::max(0.0, a.speed * a.speed + 2 * acceleration * driven));
  return std::min(a.time + (a.speed + speed > 0 ? 2 * driven / (a.speed + speed) : b.time - a.time), b.time);
}

Sway::Sway(const Value& value, std::uint64_t seed) {
  Fields f(value, "sway");
  f.also({"roll_deg", "pitch_deg", "heave_m"}).finish();
  roll_ = radians(f.number("roll_deg", {0, 10}, 0));
  pitch_ = radians(f.number("pitch_deg", {0, 10}, 0));
  heave_ = f.number("heave_m", {0, 1}, 0);
  constexpr double kLowest = 0.6;  // Hz, limits of the sinusoids' frequencies
  constexpr double kHighest = 2;
  for (std::uint32_t axis = 0; axis < waves_.size(); ++axis) {
    for (std::uint32_t k = 0; k < kWaves; ++k) {
      const std::uint32_t wave = axis * static_cast<std::uint32_t>(kWaves) + k;
      const RandomBlock block = randomBlock({.seed = seed, .beam = wave, .purpose = Purpose::Sway});
      const double hertz = kLowest + (kHighest - kLowest) * (k + uniform(block[0])) / kWaves;
      waves_[axis][k] = {.frequency = 2 * kPi * hertz, .phase = 2 * kPi * uniform(block[1])};
    }
  }
}

// Returns a sum of sinusoids at a time (s), scaled so that its variance over time is 1.
double Sway::sum(const Waves& waves, double time) {
  double sines = 0;
  for (const Wave& wave : waves) sines += std::sin(wave.frequency * time + wave.phase);
  return sines * std::sqrt(2.0 / kWaves);
}

Pose Sway::at(double time, double speedFraction) const {
  if (roll_ == 0 && pitch_ == 0 && heave_ == 0) return {};
  const double roll = speedFraction * roll_ * sum(waves_[0], time);
  const double pitch = speedFraction * pitch_ * sum(waves_[1], time);
  return {fromYawPitchRoll(0, pitch, roll), {0, 0, speedFraction * heave_ * sum(waves_[2], time)}};
}

}  // namespace scanmill
