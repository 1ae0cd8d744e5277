#pragma once

// The sway of a vehicle on its springs while it drives.

#include <array>
#include <cstdint>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// Roll, pitch and heave as sums of sinusoids of 0.6 to 2 Hz, the resonance frequencies of car bodies. Frequencies and
// phases are random and follow from a seed. The sums are smooth and nearly normally distributed over time.
class Sway {
 public:
  Sway() = default;  // no sway
  // Reads {roll_deg: 0.5, pitch_deg: 0.3, heave_m: 0.01} from YAML: standard deviations while the vehicle drives at the
  // full speed of its drive. Throws InputError.
  Sway(const Value& value, std::uint64_t seed);

  // Returns the pose of the swaying vehicle in the frame of the vehicle without sway, at a time (s). `part`: the
  // vehicle's speed as a fraction of the full speed, with which the sway is scaled.
  Pose at(double time, double part) const;

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
