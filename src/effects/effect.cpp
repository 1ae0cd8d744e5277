#include "effects/effect.h"

#include <fmt/format.h>

#include <array>

#include "effects/makers.h"

namespace scanmill {

std::span<const EffectEntry> effects() {
  static constexpr std::array<EffectEntry, 6> kEffects{{
      {"intensity", "strength of the echo: diffuse, specular and retroreflective, over range and air, then the sensor",
       0, makeIntensity},
      {"dropout", "echoes that are not reported: too faint, or lost at random", 1, makeDropOut},
      {"range_noise", "Gaussian error of the range along the beam", 2, makeRangeNoise},
      {"shell", "random vector of fixed length added to the point; for comparison with published datasets", 2,
       makeShellNoise},
      {"quantize", "ranges in whole steps", 3, makeQuantize},
      {"angular_jitter", "Gaussian error of the beam's azimuth and elevation", 4, makeAngularJitter},
  }};
  return kEffects;
}

const EffectEntry& requireEffect(std::string_view name, const Location& where) {
  for (const EffectEntry& entry : effects()) {
    if (entry.name == name) return entry;
  }
  std::vector<std::string> names;
  for (const EffectEntry& entry : effects()) names.emplace_back(entry.name);
  throw InputError(where, fmt::format("unknown effect '{}'{}", name, suggestion(name, names)));
}

}  // namespace scanmill
