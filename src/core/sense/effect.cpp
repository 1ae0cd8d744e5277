#include "sense/effect.h"

#include <algorithm>
#include <array>

#include "sense/effects/makers.h"

namespace scanmill {

std::span<const EffectEntry> effects() {
  static constexpr std::array<EffectEntry, 16> kEffects{{
      {"footprint", "beams of finite width: several rays per beam add up to echoes; mixed pixels at edges",
       "rays: required, 7, 19, 37, 61, 91 or 127 a beam; needs `divergence_mrad` and `pulse_ns` of the sensor", 0,
       makeFootprintEffect},
      {"light_paths", "rays continue behind glass and off mirrors: car windows, mirror images",
       "panes: 4, most panes of glass (materials with a `transmission`) that a ray passes, 0 to 16\n"
       "bounces: 1, most reflections of a ray by mirrors (`roughness` of at most 0.1), 0 to 4\n"
       "least: 0.001, share of a beam's power below which a ray is not followed\n"
       "mirrored: class, class of mirror images: class (that of the surface) or unlabeled",
       0, makeLightPaths},
      {"ring_bias", "fixed errors of each laser in range, elevation and gain, random per sensor or as listed",
       "range_sigma_m: 0 m, standard deviation over the rings of the range's offset\n"
       "elevation_sigma_deg: 0 deg, standard deviation over the rings of the elevation's error\n"
       "gain_sigma: 0, standard deviation over the rings of the gain's natural logarithm (needs `intensity`)\n"
       "range_m: none, in place of `range_sigma_m`: a list of offsets in m, one per ring\n"
       "elevation_deg: none, in place of `elevation_sigma_deg`: a list of errors in degrees, one per ring\n"
       "gain: none, in place of `gain_sigma`: a list of factors, one per ring; 1 is no error (needs `intensity`)",
       0, makeRingBias},
      {"relief", "rough surfaces: grass, gravel, stone and bark reflect beams before or behind the mesh",
       "strength: 1, factor on the heights of the materials' `relief`, 0 to 10", 0, makeRelief},
      {"reflectance_variation", "reflectance that varies over a surface: patches, grass, bricks, dirt",
       "strength: 1, factor on the contrasts of the materials' `variations`, 0 to 10 (needs `intensity`)", 0,
       makeReflectanceVariation},
      {"weather", "rain, snow, fog or dust: faint returns are lost, particles give returns, the ground is wet",
       "kind: required, rain, snow, fog or dust (needs `intensity`, whose `near_range_m` limits the echoes of near "
       "particles: a warning tells of its default; a sensor without `divergence_mrad` or `pulse_ns` has 3 mrad and 5 "
       "ns, and a warning)\n"
       "severity: moderate, light (rain 1.5 mm/h, snow 0.5 mm/h, fog and dust 500 m), moderate (5, 1.5, 150) or "
       "heavy (25, 4, 50)\n"
       "rate_mm_h: by `severity`, of rain or snow, mm of water an hour, 0.01 to 200 (snow: 50)\n"
       "visibility_m: by `severity`, of fog or dust: the meteorological optical range, 1 to 1e5\n"
       "wet: by `severity`, share of upward surfaces under standing water: 0.1, 0.3 or 0.6 in rain, else 0; above 0, "
       "all upward surfaces are darker\n"
       "least: 0.001 or half of the threshold of `detection` if that is less, power below which particles are ignored: "
       "1 is a white target at 10 m (with `falloff: none`, at any range)\n"
       "label: 0, class of the particles' returns, by its id or name, such as `noise` of the program's own ontology",
       0, makeWeather},
      {"blooming", "retroreflectors give returns to beams that narrowly miss them",
       "share: 0.001, part of a retroreflector's echo that beams close beside it get (needs `intensity`)\n"
       "angle_deg: 0.5 deg, angle from the retroreflector at which that part has fallen to 1/e^2\n"
       "above: 10, least retroreflectance that blooms, in units of a white target\n"
       "label: 0, class of these returns, by its id or name",
       0, makeBlooming},
      {"speckle", "speckle of laser light: the power of each return times a gamma-distributed factor",
       "looks: required, 1 to 30 speckle patterns that are averaged: the power's variance is 1 / looks (needs "
       "`intensity`)",
       0, makeSpeckle},
      {"intensity",
       "strength of the return: diffuse, specular and retroreflective, by range and air; then the sensor's response",
       "reference_range_m: 10 m, range at which a white diffuse target has power 1\n"
       "falloff: inverse_square, how the power falls with the range: inverse_square or none\n"
       "near_range_m: 1 m, below this range the power no longer grows, since the receiver does not see the whole beam; "
       "7 to 25 m in the presets\n"
       "attenuation_per_m: 0 1/m, extinction of the air, counted both ways\n"
       "gain: 1, factor of the power\n"
       "saturation: 1 for u8 and none for float, largest gain * power\n"
       "gamma: 1, exponent of the response\n"
       "output: float, type of the intensity: float or u8 (0 to 255)\n"
       "model: power, what is reported: power or reflectivity (the power corrected to the reference range and for "
       "`attenuation_per_m`, as calibrated sensors report, not corrected for rain and fog)\n"
       "diffuse: lambertian, diffuse reflection: lambertian or oren_nayar (rough surfaces, which stay bright at "
       "grazing incidence)\n"
       "retro_full_scale: none, gives bytes of reflectivity as in manuals: 0 to 100 diffuse surfaces, above that "
       "retroreflectors; 255 is a surface that reflects this many times as much as a white target\n"
       "table: none, in place of `gain`, `gamma` and `saturation`: [[value, intensity], ...] with the value that the "
       "`model` gives, linear in its logarithm, constant outside\n"
       "range_response: none, [[range in m, factor], ...]: factor on the value that the `model` gives, linear in the "
       "logarithm of the range, constant outside, for units that correct the range's loss imperfectly\n"
       "floor: 0, received power that the sensor does not measure and that is taken off before the response: 1 is a "
       "white target at the reference range; fainter returns have the intensity 0\n"
       "noise: 0, standard deviation of the intensity, in parts of the full scale\n"
       "step: 0, the intensity is a multiple of this part of the full scale",
       1, makeIntensity},
      {"detection", "echoes that exceed the receiver's noise, false positives, and which returns are reported",
       "returns: strongest, which echoes are reported: strongest, first, last, dual (strongest and last), all, or a "
       "number of the strongest, 1 to 16\n"
       "noise: 0, the receiver's noise, standard deviation in units of power: 1 is a white target at the reference "
       "range (needs `intensity`)\n"
       "threshold: 4.8, least signal that is detected, in units of the noise (needs `noise`)\n"
       "min_separation_m: 0 m, an echo nearer than this to a stronger one of its beam is not reported\n"
       "sun: none, {azimuth_deg:, elevation_deg:, noise:}, in the world's frame: the noise that a white surface "
       "facing the sun adds (needs `noise`)\n"
       "interference: 0, probability per beam of a return from another sensor's pulse (needs `noise`)",
       2, makeDetection},
      {"dropout", "returns that are not reported: too faint, or lost at random",
       "threshold: 0, least power that is reported: 1 is a white target at the reference range (needs `intensity`)\n"
       "probability: 0, share of the returns that are lost at random\n"
       "things: false, true: only returns of things are lost at random, as from dark or shiny paint (needs "
       "`probability`)\n"
       "rings: 0, share of the rings that report nothing, chosen at random once per sensor",
       2, makeDropOut},
      {"range_noise", "Gaussian error of the range along the beam",
       "sigma_m: 0 m, constant part of the standard deviation\n"
       "sigma_per_m: 0 m/m, growth of the standard deviation with the range\n"
       "table: none, in place of `sigma_m` and `sigma_per_m`: [[range m, sigma m], ...], linear between, constant "
       "beyond\n"
       "over_snr_m: 0 m, a further deviation, added in squares: this value over the signal-to-noise ratio, times the "
       "stretch of the echo (needs `detection` with `noise`)",
       3, makeRangeNoise},
      {"range_walk", "strong returns seem nearer, since their pulses cross the threshold earlier",
       "per_decade_m: required, decrease of the range for each factor of ten of the power (needs `intensity`)\n"
       "above: 1, power above which the range decreases: 1 is a white target at the reference range",
       3, makeRangeWalk},
      {"shell", "random vector of fixed length added to the point; for comparison with published datasets",
       "scale_m: 0 m, length of the random vector at range 0\n"
       "growth_per_m: 0 m/m, growth of the length with the range",
       3, makeShellNoise},
      {"quantize", "ranges rounded to whole steps", "step_m: required, step of the ranges in m, 1e-6 to 10", 4,
       makeQuantize},
      {"angular_jitter", "Gaussian error of the beam's azimuth and elevation",
       "sigma_deg: 0 deg, standard deviation of both angles\n"
       "azimuth_sigma_deg: `sigma_deg`, standard deviation of the azimuth, about the sensor's axis\n"
       "elevation_sigma_deg: `sigma_deg`, standard deviation of the elevation",
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

std::uint32_t mostReturns(EffectList effects) {
  std::uint32_t most = 1;  // before any effect: each ray has one hit
  for (const auto& effect : effects) most = effect->mostReturns(most);
  return most;
}

double intensityFullScale(EffectList effects) {
  for (const auto& effect : effects) {
    if (effect->setsIntensity()) return effect->intensityFullScale();
  }
  return 0;
}

const EffectEntry& requireEffect(std::string_view name, const Location& where) {
  return requireNamed(effects(), "effect", name, where);
}

}  // namespace scanmill
