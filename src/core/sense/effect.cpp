#include "sense/effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sense/effects/makers.h"

namespace scanmill {

std::span<const EffectEntry> effects() {
  static constexpr std::array<EffectEntry, 16> kEffects{{
      {"footprint", "beams of finite width: several rays per beam add up to echoes; mixed pixels at edges",
       "rays: required, 7, 19, 37, 61, 91 or 127 a beam", 0, makeFootprintEffect},
      {"light_paths", "rays continue behind glass and off mirrors: car windows, mirror images",
       "panes: 4, the greatest number of glass panes that a ray passes; "
       "bounces: 1, the greatest number of mirrors that reflect a ray; "
       "least: 0.001, share of a beam's power below which a ray is not followed; "
       "mirrored: class or unlabeled, whether mirror images keep their class",
       0, makeLightPaths},
      {"ring_bias", "fixed errors of each laser in range, elevation and gain, random per sensor or as listed",
       "range_sigma_m: 0 m, spread of the range's offset over the rings; "
       "elevation_sigma_deg: 0 deg, spread of the elevation's error; "
       "gain_sigma: 0, spread of the gain's natural logarithm; "
       "range_m: none, a list of range offsets in m, one per ring, instead of the spread; "
       "elevation_deg: none, a list of elevation errors in deg, one per ring, instead of the spread; "
       "gain: none, a list of factors, one per ring, instead of the spread, 1 is no error",
       0, makeRingBias},
      {"relief", "rough surfaces: grass, gravel, stone and bark reflect beams before or behind the mesh",
       "strength: 1, factor on the values of the material table", 0, makeRelief},
      {"reflectance_variation", "reflectance that varies over a surface: patches, grass, bricks, dirt",
       "strength: 1, factor on the values of the material table", 0, makeReflectanceVariation},
      {"weather", "rain, snow, fog or dust: faint returns are lost, particles give returns, the ground is wet",
       "kind: required, rain, snow, fog or dust; "
       "severity: moderate, or light or heavy; "
       "rate_mm_h: from the severity, precipitation of rain or snow in mm of water per hour; "
       "visibility_m: from the severity, meteorological optical range in fog or dust; "
       "wet: from the severity, share of the ground under standing water; "
       "least: 0.001, power below which particles are ignored, 1 is a white target at 10 m; "
       "label: 0, class of the particles' returns, by its id or name",
       0, makeWeather},
      {"blooming", "retroreflectors give returns to beams that narrowly miss them",
       "share: 0.001, part of a retroreflector's echo that beams right beside it get; "
       "angle_deg: 0.5 deg, angle from the retroreflector at which this part has fallen to 1/e^2 of its value; "
       "above: 10, the least retroreflectance that blooms, in units of a white target; "
       "label: 0, class of these returns, by its id or name",
       0, makeBlooming},
      {"speckle", "speckle of laser light: the power of each return times a gamma-distributed factor",
       "looks: required, 1 to 30, number of averaged speckle patterns, the variance is 1 / looks", 0, makeSpeckle},
      {"intensity",
       "strength of the return: diffuse, specular and retroreflective, by range and air; then the sensor's response",
       "reference_range_m: 10 m, where a white diffuse target has power 1; "
       "falloff: inverse_square or none; "
       "near_range_m: 1 m, nearer targets gain nothing; "
       "attenuation_per_m: 0 1/m, extinction of the air, counted both ways; "
       "gain: 1; "
       "saturation: 1 for u8, none for float, the largest value of gain * power; "
       "gamma: 1, exponent of the response; "
       "output: float or u8 (0 to 255); "
       "model: power or reflectivity, which is the power corrected to the reference range and clear air; "
       "diffuse: lambertian or oren_nayar, for rough surfaces that stay bright at grazing incidence; "
       "retro_full_scale: none, the retroreflectance that gives 255, in units of a white target, if bytes of "
       "reflectivity use 0 to 100 for diffuse surfaces; "
       "table: none, instead of gain, gamma and saturation, [[value, intensity], ...], linear in the value's "
       "logarithm; "
       "floor: 0, received power that the sensor does not measure: less gives the intensity 0; "
       "noise: 0, standard deviation of the intensity, in parts of the full scale; "
       "step: 0, the intensity is a multiple of this part of the full scale",
       1, makeIntensity},
      {"detection", "echoes that exceed the receiver's noise, false positives, and which returns are reported",
       "returns: strongest, first, last, dual (strongest and last), all, or a number N for the N strongest; "
       "noise: 0, standard deviation in units of power, 1 is a white target at the reference range; "
       "threshold: 4.8, the least signal of an echo that is found, in units of the noise; "
       "min_separation_m: 0 m, an echo nearer than this to a stronger one is not reported; "
       "sun: none, {azimuth_deg:, elevation_deg:, noise:} of daylight that surfaces reflect; "
       "interference: 0, probability per beam of a return from another sensor's pulse",
       2, makeDetection},
      {"dropout", "returns that are not reported: too faint, or lost at random",
       "threshold: 0, the least power that is reported, 1 is a white target at the reference range; "
       "probability: 0, share lost at random; "
       "things: false, true loses only returns of things at random; "
       "rings: 0, share of the rings that report nothing, random per sensor",
       2, makeDropOut},
      {"range_noise", "Gaussian error of the range along the beam",
       "sigma_m: 0 m, constant part; "
       "sigma_per_m: 0 m/m, growth with the range; "
       "table: none, instead of these two, [[range m, sigma m], ...], linear between and constant beyond; "
       "over_snr_m: 0 m, divided by the signal-to-noise ratio, times the echo's stretch, and added in quadrature",
       3, makeRangeNoise},
      {"range_walk", "strong returns seem nearer, since their pulses cross the threshold earlier",
       "per_decade_m: required, m per factor of ten of the power, by which the range falls; above: 1, power above "
       "which the range falls, 1 is a white target at the reference range",
       3, makeRangeWalk},
      {"shell", "random vector of fixed length added to the point; for comparison with published datasets",
       "scale_m: 0 m, length of the vector at range 0; growth_per_m: 0 m/m, growth with the range", 3, makeShellNoise},
      {"quantize", "ranges rounded to whole steps", "step_m: required, m, the step", 4, makeQuantize},
      {"angular_jitter", "Gaussian error of the beam's azimuth and elevation",
       "sigma_deg: 0 deg, standard deviation of both angles; "
       "azimuth_sigma_deg: sigma_deg, standard deviation of the azimuth; "
       "elevation_sigma_deg: sigma_deg, standard deviation of the elevation",
       5, makeAngularJitter},
  }};
  return kEffects;
}

std::uint32_t raysPerBeam(EffectList effects) {
  std::uint32_t most = 1;
  for (const auto& effect : effects) most = std::max(most, effect->raysPerBeam());
  return most;
}

const LightPaths* lightPaths(EffectList effects) {
  for (const auto& effect : effects) {
    if (effect->lightPaths() != nullptr) return effect->lightPaths();
  }
  return nullptr;
}

std::uint32_t mostReturns(EffectList effects, std::uint32_t met) {
  for (const auto& effect : effects) met = effect->mostReturns(met);
  return met;
}

double intensityFullScale(EffectList effects) {
  for (const auto& effect : effects) {
    if (effect->setsIntensity()) return effect->intensityFullScale();
  }
  return 0;
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
