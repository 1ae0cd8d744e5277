// intensity: how strong the return of each beam is, and what the sensor makes of it.
//
//   intensity: {reference_range_m: 10, falloff: inverse_square, near_range_m: 1, attenuation_per_m: 0,
//               gain: 1, saturation: 4, gamma: 1, output: float}
//
// The power is 1.0 for a white Lambertian target at normal incidence at the reference range in clear air:
//
//   power = (cos t * (diffuse + retroreflectance) + specular(t)) * (reference / max(r, near))^2 * exp(-2 sigma r)
//
// the lidar equation for a target wider than the beam (Hoefle and Pfeifer, "Correction of laser scanning intensity
// data", ISPRS Journal 62, 2007), with sigma the extinction of the air (Beer and Lambert, both ways).
// `near_range` stands for the overlap of emitter and receiver: nearer targets gain nothing. falloff: none leaves the
// square out, as sensors do that correct for range.
//
// specular(t) is a microfacet surface (Torrance and Sparrow 1967) of which the sensor sees what it lights: the half
// vector is the beam, so D F G / (4 cos^2 t) of Walter et al., "Microfacet models for refraction through rough
// surfaces", EGSR 2007, eq. 20, times pi cos t, has F = F0, D of their eq. 33 (GGX), and, as shadowing and masking
// coincide, G = 1 / (1 + Lambda) (Heitz, "Understanding the masking-shadowing function in microfacet-based BRDFs",
// JCGT 3(2), 2014, eq. 72 for Lambda of GGX; section 5 for correlated directions).
//
// The response: v = min(gain * power, saturation) ^ gamma for output float; 255 * (min(gain * power, saturation) /
// saturation) ^ gamma, rounded, for output u8, with a saturation of 1 unless one is given. A miss gets 0.

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

// A lobe is never narrower than the beam: 4 mrad is wide for a beam.
constexpr float kSmallestAlpha = 0.004f;
constexpr float kDielectricF0 = 0.04f;  // refractive index 1.5, as glTF

struct Options {
  float referenceRange = 10;  // m
  float nearRange = 1;        // m
  bool inverseSquare = true;
  double attenuation = 0;  // 1/m
  float gain = 1;
  float saturation = FLT_MAX;
  double gamma = 1;
  bool bytes = false;
};

// What a material does to light that comes back along its way: diffuse = matt * reflectance, F0 = glossy + metal *
// reflectance.
struct Lobes {
  float matt = 1;
  float metal = 0;
  float glossy = 0;
  float alpha2 = 1;
  float retro = 0;
};

Lobes lobesOf(float givenRoughness, float givenMetallic, float retroreflectance) {
  const float roughness = std::clamp(givenRoughness, 0.0f, 1.0f);
  const float metallic = std::clamp(givenMetallic, 0.0f, 1.0f);
  // glTF's roughness is the root of GGX's alpha (Burley, "Physically based shading at Disney", 2012). A dielectric of
  // roughness 1 is matt: all that it reflects is diffuse; what is glossy is taken from the diffuse part.
  const float alpha = roughness * roughness;
  const float glossy = kDielectricF0 * (1 - alpha);
  const float width = std::max(alpha, kSmallestAlpha);
  return {(1 - metallic) * (1 - glossy), metallic, (1 - metallic) * glossy, width * width,
          std::max(retroreflectance, 0.0f)};
}

// A matt surface's `reflectance` at the cosine c of the angle of incidence, in units of a white one's at normal
// incidence.
float reflected(const Lobes& lobe, float c, float reflectance) {
  const float sin2 = (1 - c) * (1 + c);
  const float width = lobe.alpha2 * c * c + sin2;
  const float f0 = lobe.glossy + lobe.metal * reflectance;
  // pi D F0 G / (4 cos t), with cos t taken into G = 2 cos t / (cos t + sqrt(cos^2 t + alpha^2 sin^2 t)).
  const float masking = c + std::sqrt(c * c + lobe.alpha2 * sin2);
  const float specular = f0 * lobe.alpha2 / (2 * width * width * masking);
  return c * (lobe.matt * reflectance + lobe.retro) + specular;
}

class Intensity : public Effect {
 public:
  explicit Intensity(const Options& options) : o_(options) {}

  Channels reads() const override {
    return Channel::Range | Channel::Material | Channels(Channel::Reflectance) | Channel::Incidence;
  }
  bool setsIntensity() const override { return true; }

  void apply(const Hits& hits, const Shot&, std::span<const Material> materials, Returns& returns) const override {
    change(hits, materials, returns);
  }

 private:
  SCANMILL_BEST_INSTRUCTIONS void change(const Hits& hits, std::span<const Material> materials,
                                         Returns& returns) const {
    std::vector<Lobes> lobes;
    lobes.reserve(materials.size() + 1);
    for (const Material& m : materials) lobes.push_back(lobesOf(m.roughness, m.metallic, m.retroreflectance));
    lobes.emplace_back();  // for what has no material: matt

    returns.power.resize(returns.size());
    returns.intensity.assign(returns.size(), 0);
    Batch<float> ranges;
    Batch<float> given;
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      float* const power = returns.power.data() + first;
      for (std::size_t i = 0; i < count && !returns.onePerBeam(); ++i) given[i] = power[i];
      reflect(hits, lobes, returns, first, count, power);
      travel(valuesOfHits(returns, hits.range, first, ranges, kMiss), count, power);
      for (std::size_t i = 0; i < count; ++i) {
        const float finite = power[i] < FLT_MAX ? power[i] : FLT_MAX;
        const bool returned = returns.range[first + i] < kMiss;
        power[i] = returned && power[i] > 0 ? finite : 0;
      }
      if (!hits.weightOfRay.empty()) share(hits, returns, first, count, power);
      for (std::size_t i = 0; i < count && !returns.onePerBeam(); ++i) {
        power[i] = returns.hit(first + i) == kNoHit ? given[i] : power[i];  // as the effect that added the row says
      }
      respond(power, count, returns.intensity.data() + first);
    });
  }

  static void reflect(const Hits& hits, const std::vector<Lobes>& lobes, const Returns& returns, std::size_t first,
                      std::size_t count, float* power) {
    Batch<std::uint16_t> materials;
    Batch<float> reflectances;
    Batch<float> incidences;
    const std::uint16_t* const material = valuesOfHits(returns, hits.material, first, materials);
    const float* const reflectance = valuesOfHits(returns, hits.reflectance, first, reflectances);
    const float* const incidence = valuesOfHits(returns, hits.incidence, first, incidences);
    if (!hits.roughness.empty()) {  // as the hits say, not the materials
      Batch<float> buffers[3];
      const float* const roughness = valuesOfHits(returns, hits.roughness, first, buffers[0]);
      const float* const metallic = valuesOfHits(returns, hits.metallic, first, buffers[1]);
      const float* const retro = valuesOfHits(returns, hits.retroreflectance, first, buffers[2]);
      for (std::size_t i = 0; i < count; ++i) {
        power[i] = reflected(lobesOf(roughness[i], metallic[i], retro[i]), incidence[i], reflectance[i]);
      }
      return;
    }
    const Lobes* const table = lobes.data();
    const std::uint32_t last = static_cast<std::uint32_t>(lobes.size() - 1);
    for (std::size_t i = 0; i < count; ++i) {
      const Lobes lobe = table[std::min<std::uint32_t>(material[i], last)];
      power[i] = reflected(lobe, incidence[i], reflectance[i]);
    }
  }

  // A ray has a part of its beam's power.
  static void share(const Hits& hits, const Returns& returns, std::size_t first, std::size_t count, float* power) {
    Batch<float> weights;
    const float* const weight = valuesOfHits(returns, hits.weightOfRay, first, weights, 1.0f);
    for (std::size_t i = 0; i < count; ++i) power[i] *= weight[i];
  }

  void travel(const float* range, std::size_t count, float* power) const {
    if (o_.inverseSquare) {
      for (std::size_t i = 0; i < count; ++i) {
        const float ratio = o_.referenceRange / (range[i] > o_.nearRange ? range[i] : o_.nearRange);
        power[i] *= ratio * ratio;
      }
    }
    if (o_.attenuation > 0) {
      for (std::size_t i = 0; i < count; ++i) {
        power[i] = static_cast<float>(power[i] * exponential(-2 * o_.attenuation * range[i]));
      }
    }
  }

  void respond(const float* power, std::size_t count, float* intensity) const {
    const float unit = o_.bytes ? 1 / o_.saturation : 1.0f;
    for (std::size_t i = 0; i < count; ++i) {
      const float amplified = o_.gain * power[i];
      intensity[i] = (amplified < o_.saturation ? amplified : o_.saturation) * unit;
    }
    if (o_.gamma != 1) {
      for (std::size_t i = 0; i < count; ++i) {
        const double base = intensity[i] > FLT_MIN ? intensity[i] : FLT_MIN;
        double value = exponential(o_.gamma * naturalLog(base));
        value = value < FLT_MAX ? value : FLT_MAX;
        intensity[i] = intensity[i] > FLT_MIN ? static_cast<float>(value) : 0.0f;
      }
    }
    if (o_.bytes) {
      for (std::size_t i = 0; i < count; ++i) {
        const float rounded = std::floor(255 * intensity[i] + 0.5f);
        intensity[i] = rounded < 255 ? rounded : 255.0f;
      }
    }
  }

  Options o_;
};

}  // namespace

std::unique_ptr<Effect> makeIntensity(Fields& options) {
  Options o;
  o.referenceRange = static_cast<float>(options.number("reference_range_m", {0.1, 1000}, 10));
  o.nearRange = static_cast<float>(options.number("near_range_m", {0.001, 1000}, 1));
  o.inverseSquare = options.choice("falloff", {"inverse_square", "none"}, "inverse_square") == "inverse_square";
  o.attenuation = options.number("attenuation_per_m", {0, 10}, 0);
  o.gain = static_cast<float>(options.number("gain", {0, 1e9}, 1));
  o.bytes = options.choice("output", {"float", "u8"}, "float") == "u8";
  o.saturation = static_cast<float>(options.number("saturation", {1e-9, 1e30}, o.bytes ? 1.0 : 1e30));
  o.gamma = options.number("gamma", {0.05, 10}, 1);
  options.finish();
  return std::make_unique<Intensity>(o);
}

}  // namespace scanmill
