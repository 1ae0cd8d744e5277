#include "sensors/sway.h"

#include <cmath>

#include "base/random.h"
#include "config/fields.h"

namespace scanmill {

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
