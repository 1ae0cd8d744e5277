#pragma once

// How a vehicle sways on its springs while it drives.

#include <array>
#include <cstdint>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// Roll, pitch and heave as sums of sinusoids of 0.6 to 2 Hz, where the bodies of cars resonate, with random phases that
// follow from a seed: smooth, and normally distributed over time.
class Sway {
 public:
  Sway() = default;  // none
  // Reads {roll_deg: 0.5, pitch_deg: 0.3, heave_m: 0.01} of YAML: standard deviations at the speed of the drive. Throws
  // InputError.
  Sway(const Value& value, std::uint64_t seed);

  // Returns the pose of the swaying vehicle in the frame of one that does not sway. `part`: share of the full sway,
  // which grows with the speed.
  Pose at(double time, double part) const;

 private:
  static constexpr std::size_t kWaves = 10;
  struct Wave {
    double frequency = 0;  // rad/s
    double phase = 0;      // rad
  };
  using Waves = std::array<Wave, kWaves>;
  static double sum(const Waves& waves, double time);

  double roll_ = 0, pitch_ = 0;  // rad
  double heave_ = 0;             // m
  std::array<Waves, 3> waves_{};
};

}  // namespace scanmill
