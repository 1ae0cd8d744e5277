#include "sense/effect.h"

#include <fmt/format.h>

#include <array>

#include "sense/effects/makers.h"

namespace scanmill {

std::span<const EffectEntry> effects() {
  static constexpr std::array<EffectEntry, 6> kEffects{{
      {"intensity",
       "strength of the return: diffuse, specular and retroreflective, over range and air, then the sensor",
       "reference_range_m: 10 m, where a white diffuse target has power 1; "
       "falloff: inverse_square or none; "
       "near_range_m: 1 m, nearer targets gain nothing; "
       "attenuation_per_m: 0 1/m, extinction of the air, counted both ways; "
       "gain: 1; "
       "saturation: 1 for u8, none for float, the largest gain * power; "
       "gamma: 1, exponent of the response; "
       "output: float or u8 (0 to 255)",
       0, makeIntensity},
      {"dropout", "returns that are not reported: too faint, or lost at random",
       "threshold: 0, least power that is reported, 1 is white at the reference range; "
       "probability: 0, share lost at random",
       1, makeDropOut},
      {"range_noise", "Gaussian error of the range along the beam",
       "sigma_m: 0 m, constant part; "
       "sigma_per_m: 0 m/m, growth with the range; "
       "table: none, in their place [[range m, sigma m], ...], linear between and constant beyond",
       2, makeRangeNoise},
      {"shell", "random vector of fixed length added to the point; for comparison with published datasets",
       "scale_m: 0 m, length at range 0; "
       "growth_per_m: 0 m/m, growth with the range",
       2, makeShellNoise},
      {"quantize", "ranges in whole steps", "step_m: required, m", 3, makeQuantize},
      {"angular_jitter", "Gaussian error of the beam's azimuth and elevation",
       "sigma_deg: 0 deg, of both; "
       "azimuth_sigma_deg: sigma_deg, about the sensor's axis; "
       "elevation_sigma_deg: sigma_deg",
       4, makeAngularJitter},
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
