#pragma once

// The distance that a vehicle has driven along its path, as a function of time, and its sway on its springs.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

class Path;

// A stop of a vehicle on its path.
struct DriveStop {
  double position = 0;  // m along the path
  double duration = 0;  // s
};

class SpeedProfile {
 public:
  // A drive at a constant speed (m/s) along a path of length `length` (m).
  SpeedProfile(double length, double speed);
  // A drive that starts at rest at the path's start, stops at each of `stops` and ends at rest at the path's end. In
  // between it is as fast as these limits allow: `speed` (m/s), `acceleration` (m/s^2, also for braking), and the
  // lateral acceleration kSideways in bends. The stops are positions within the path, in ascending order.
  SpeedProfile(const Path& path, double speed, double acceleration, const std::vector<DriveStop>& stops);

  static constexpr double kSideways = 2;  // m/s^2, largest lateral acceleration in bends

  double duration() const { return nodes_.back().time; }  // duration of the drive (s)
  // Returns the distance driven (m) at a time (s); 0 before the start, the path's length after the end.
  double distance(double time) const;
  double speed(double time) const;  // returns the speed (m/s) at a time (s)
  // Returns the first time (s) at which the vehicle has driven `distance` (m, at most the path's length).
  double timeAt(double distance) const;

 private:
  // The state of the vehicle at a position on its path; between two nodes the acceleration is constant.
  struct Node {
    double time;      // s
    double distance;  // m along the path
    double speed;     // m/s
  };
  std::vector<Node> nodes_;  // ascending in time and distance
};

// Roll, pitch and heave as sums of sinusoids of 0.6 to 2 Hz, the resonance frequencies of car bodies. Frequencies and
// phases are random and follow from a seed. The sums are smooth and nearly normally distributed over time.
class Sway {
 public:
  Sway() = default;  // no sway
  // Reads {roll_deg: 0.5, pitch_deg: 0.3, heave_m: 0.01} from YAML: standard deviations while the vehicle drives at the
  // full speed of its drive. Throws InputError.
  Sway(const Value& value, std::uint64_t seed);

  // Returns the pose of the swaying vehicle in the frame of the vehicle without sway, at a time (s). `speedFraction`:
  // the vehicle's speed as a fraction of the full speed, with which the sway is scaled.
  Pose at(double time, double speedFraction) const;

 private:
  static constexpr std::size_t kWaves = 10;
  struct Wave {
    double frequency = 0;  // rad/s
    double phase = 0;      // rad
  };
  using Waves = std::array<Wave, kWaves>;
  static double sum(const Waves& waves, double time);

  double roll_ = 0, pitch_ = 0;  // rad, standard deviations
  double heave_ = 0;             // m, standard deviation
  std::array<Waves, 3> waves_{};
};

}  // namespace scanmill
