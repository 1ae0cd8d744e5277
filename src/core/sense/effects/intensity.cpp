// intensity: the power of each return, and the intensity that the sensor reports for it. docs/sensing.md explains the
// options, and docs/keys.md lists them.
//
//   intensity: {reference_range_m: 10, near_range_m: 1, gain: 1, saturation: 4, gamma: 1, output: float}
//   intensity: {model: reflectivity, diffuse: oren_nayar, output: u8, retro_full_scale: 1000}
//   intensity: {model: reflectivity, output: u8, table: [[0.01, 30], [0.1, 90], [1, 160]], floor: 0.006, noise: 0.05}
//
// The power is 1.0 for a white Lambertian target at normal incidence at the reference range in clear air:
//
//   power = (cos t * (diffuse + retroreflectance) + specular(t)) * (reference / max(r, near))^2 * exp(-2 sigma r)
//
// the lidar equation for a target wider than the beam (Hoefle and Pfeifer, "Correction of laser scanning intensity
// data", ISPRS Journal 62, 2007), with sigma the extinction of the air (Beer and Lambert, both ways). Nearer than
// near_range_m the detector does not receive all light that the lens collects, which cancels the growth with 1 / r^2
// (Harms et al., "Geometrical compression of lidar return signals", Applied Optics 17, 1978). Effects that run earlier
// may set Returns::gain, a factor on the power.
//
// specular(t) is the reflection of a microfacet surface (Torrance and Sparrow 1967) back along the beam, so the half
// vector is the beam itself. It is pi cos t times D F G / (4 cos^2 t) (Walter et al., "Microfacet models for refraction
// through rough surfaces", EGSR 2007, eq. 20), with F = F0, D of their eq. 33 (GGX), and, since shadowing and masking
// coincide, G = 1 / (1 + Lambda) (Heitz, "Understanding the masking-shadowing function in microfacet-based BRDFs",
// JCGT 3(2), 2014, eq. 72 for Lambda of GGX; section 5 for correlated directions).
//
// `diffuse: oren_nayar` replaces the cosine of the diffuse part by A cos t + B sin^2 t (Oren and Nayar, "Generalization
// of Lambert's reflectance model", SIGGRAPH 1994, eq. 30, with both directions along the beam; A = 1 - 0.5 s^2 / (s^2 +
// 0.33), B = 0.45 s^2 / (s^2 + 0.09)). s is the angle whose tangent is alpha / sqrt(2), the root-mean-square slope of a
// Beckmann surface of the same alpha (GGX's slopes have no variance).
//
// The reported value is the power or, with `model: reflectivity`, the power of the same surface at the reference range
// in clear air; other effects read the received power in both cases. The value is then multiplied by `range_response`,
// which is interpolated in log(range), and by the fraction of the received power that exceeds `floor`. The response to
// v = gain * value is min(v, saturation)^gamma for floats, and 255 (min(v, saturation) / saturation)^gamma for bytes.
// With retro_full_scale the response is 100 v up to v = 1, and 100 + 155 log(v) / log(retro_full_scale) above
// (Velodyne, VLP-16 User Manual 63-9243 Rev. D, section 6.1). With `table` the response is interpolated in log(value).
// Then `noise` is added and the sum rounded to multiples of `step`.

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

// Lower limit of GGX's alpha: specular lobes are at least as wide as a wide beam, 4 mrad.
constexpr float kSmallestAlpha = 0.004f;
constexpr float kDielectricF0 = 0.04f;  // F0 of dielectrics with the refractive index 1.5, as in glTF

// A function of a positive number: pairs of the number's natural logarithm, ascending, and the function's value.
using LogTable = std::vector<std::pair<double, double>>;

// Returns a function's value at x by linear interpolation over log(x); constant outside of the table. Does not search:
// adds, to the first value, each interval's rise up to x.
double interpolated(const LogTable& table, float x) {
  const double logarithm = naturalLog(x > FLT_MIN ? x : FLT_MIN);
  double sum = table.front().second;
  for (std::size_t k = 1; k < table.size(); ++k) {
    const auto& [low, valueAtLow] = table[k - 1];
    const auto& [high, valueAtHigh] = table[k];
    double fraction = (logarithm - low) / (high - low);
    fraction = fraction > 0 ? fraction : 0;
    fraction = fraction < 1 ? fraction : 1;
    sum += fraction * (valueAtHigh - valueAtLow);
  }
  return sum;
}

struct IntensityOptions {
  float referenceRange = 10;  // m, range at which a white diffuse target has the power 1
  float nearRange = 1;        // m, targets nearer than this have the power that they would have at this range
  bool inverseSquare = true;
  double attenuation = 0;  // 1/m, extinction coefficient of the air
  float gain = 1, saturation = FLT_MAX;
  double gamma = 1;
  bool bytes = false;
  bool reflectivity = false;  // true: reports the power that a hit at the reference range would give in clear air
  bool orenNayar = false;
  double retroFullScale = 0;  // `retro_full_scale`; 0: bytes are proportional to the response
  LogTable table;             // intensity by value; empty: no table
  LogTable rangeResponse;     // factor on the value by range (m); empty: 1
  float floor = 0;            // received power that the sensor does not measure
  double noise = 0;           // standard deviation, as a fraction of the full scale
  double step = 0;            // rounding step, as a fraction of the full scale; 0: none
};

// How a material reflects light back along the beam: the diffuse reflectance is matt * reflectance, and F0 (reflectance
// of facets at normal incidence) is glossy + metal * reflectance.
struct Lobes {
  float matt = 1, metal = 0, glossy = 0;
  float alpha2 = 1;   // square of GGX's alpha
  float retro = 0;    // retroreflectance
  float even = 1;     // factor of cos t in the diffuse part; t: angle of incidence
  float grazing = 0;  // factor of sin^2 t in the diffuse part
};

constexpr double kHalfRoot = 0.70710678118654752440;

// Returns the arc tangent (rad) of t, which must be from 0 to kHalfRoot. Unlike std::atan(), gives the same result on
// all machines: halves the angle by atan(t) = 2 atan(t / (1 + sqrt(1 + t^2))), and then uses the power series. Errors:
// 1e-9.
double angleOfSlope(double t) {
  const double half = t / (1 + std::sqrt(1 + t * t));
  const double z = half * half;
  const double tail = 1.0 / 9 - z * (1.0 / 11 - z * (1.0 / 13 - z * (1.0 / 15 - z * (1.0 / 17 - z * (1.0 / 19)))));
  return 2 * half * (1 - z * (1.0 / 3 - z * (1.0 / 5 - z * (1.0 / 7 - z * tail))));
}

// Returns the lobes of a material with glTF's roughness and metallic factor, which are clamped to 0 to 1. `orenNayar`:
// true for the diffuse reflection of a rough surface, false for a Lambertian one.
Lobes lobesOf(float roughness, float metallic, float retroreflectance, bool orenNayar) {
  roughness = std::clamp(roughness, 0.0f, 1.0f);
  metallic = std::clamp(metallic, 0.0f, 1.0f);
  // glTF's roughness is the square root of GGX's alpha (Burley, "Physically based shading at Disney", 2012). A
  // dielectric of roughness 1 reflects only diffusely; at a lower roughness, the glossy part reduces the diffuse part.
  const float alpha = roughness * roughness;
  const float glossy = kDielectricF0 * (1 - alpha);
  const float lobeAlpha = std::max(alpha, kSmallestAlpha);
  Lobes lobes{.matt = (1 - metallic) * (1 - glossy),
              .metal = metallic,
              .glossy = (1 - metallic) * glossy,
              .alpha2 = lobeAlpha * lobeAlpha,
              .retro = std::max(retroreflectance, 0.0f)};
  if (orenNayar) {
    const double s = angleOfSlope(alpha * kHalfRoot);  // rad, s in the formulas at the top of this file
    lobes.even = static_cast<float>(1 - 0.5 * s * s / (s * s + 0.33));
    lobes.grazing = static_cast<float>(0.45 * s * s / (s * s + 0.09));
  }
  return lobes;
}

// Returns the light that a surface reflects back along the beam, relative to a white matt surface at normal incidence.
// `c`: cosine of the angle of incidence.
float reflected(const Lobes& lobe, float c, float reflectance) {
  const float sin2 = (1 - c) * (1 + c);
  const float width = lobe.alpha2 * c * c + sin2;
  const float f0 = lobe.glossy + lobe.metal * reflectance;
  // The specular part is pi D F0 G / (4 cos t) with G = 2 cos t / (cos t + sqrt(cos^2 t + alpha^2 sin^2 t)), so that
  // cos t cancels out.
  const float masking = c + std::sqrt(c * c + lobe.alpha2 * sin2);
  const float specular = f0 * lobe.alpha2 / (2 * width * width * masking);
  const float diffuse = lobe.matt * reflectance;
  return c * (diffuse * lobe.even + lobe.retro) + diffuse * lobe.grazing * sin2 + specular;
}

class Intensity : public Effect {
 public:
  explicit Intensity(IntensityOptions options) : o_(std::move(options)) {}

  Channels reads() const override {
    return Channel::Range | Channel::Material | Channels(Channel::Reflectance) | Channel::Incidence;
  }
  std::optional<Falloff> falloff() const override {
    return Falloff{double{o_.referenceRange}, double{o_.nearRange}, o_.inverseSquare};
  }
  bool setsIntensity() const override { return true; }
  double intensityFullScale() const override { return o_.bytes ? 255 : 1; }

  bool powerOfRays(const Hits& hits, std::span<const Material> materials, std::vector<float>& power) const override {
    powerOf(hits, materials, power);
    return true;
  }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials, Returns& returns) const override {
    change(hits, shot, materials, returns);
  }

 private:
  // Returns the lobes of each material and, as the last element, the lobes of surfaces without a material, which are
  // matt. `glass`: true if rays continue behind glass; panes then have no diffuse reflection.
  std::vector<Lobes> lobesOfAll(std::span<const Material> materials, bool glass) const {
    std::vector<Lobes> lobes;
    lobes.reserve(materials.size() + 1);
    for (const Material& m : materials) {
      lobes.push_back(lobesOf(m.roughness, m.metallic, m.retroreflectance, o_.orenNayar));
      if (glass && m.transmission > 0) lobes.back().matt = 0;
    }
    lobes.emplace_back();
    return lobes;
  }

  // Does the work of powerOfRays(), which cannot be marked SCANMILL_BEST_INSTRUCTIONS because it is virtual.
  SCANMILL_BEST_INSTRUCTIONS void powerOf(const Hits& hits, std::span<const Material> materials,
                                          std::vector<float>& power) const {
    const std::vector<Lobes> lobes = lobesOfAll(materials, hits.glassIsClear);
    const Returns rays;  // an empty table has one row per beam, so the rows of a batch are hits
    power.assign(hits.rays(), 0);
    forBatches(hits.range, [&](std::size_t first, std::size_t count) {
      float* const batchPower = power.data() + first;
      const float* const range = hits.range.data() + first;
      setReflected(hits, rays, first, lobes, count, batchPower);
      multiply(hits.weightOfRay, first, count, batchPower);
      applyRangeLoss(range, count, batchPower);
      clampPower(range, count, batchPower);
    });
  }

  // Sets the power and the reported intensity of all rows.
  SCANMILL_BEST_INSTRUCTIONS void change(const Hits& hits, const Shot& shot, std::span<const Material> materials,
                                         Returns& returns) const {
    const std::vector<Lobes> lobes = lobesOfAll(materials, hits.glassIsClear);
    returns.power.resize(returns.size());
    returns.intensity.assign(returns.size(), 0);
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      Batch<float> reflectivity;
      setPower(hits, lobes, first, count, returns, reflectivity.data());
      report(shot, first, count, returns, reflectivity.data());
    });
  }

  // Sets the received power of a batch of rows, and `reflectivity`, the power that the rows would have if they came
  // from the reference range through clear air. `reflectivity` is complete only with `model: reflectivity`.
  //
  // At the call Returns::power holds the received power of rows of echoes (if `powerOfEchoes`), the power at the
  // reference range of rows that effects have added, and no value for other rows.
  void setPower(const Hits& hits, const std::vector<Lobes>& lobes, std::size_t first, std::size_t count,
                Returns& returns, float* reflectivity) const {
    float* const power = returns.power.data() + first;
    const float* const range = returns.range.data() + first;
    Batch<float> powerOfAdded;
    if (!returns.onePerBeam()) std::copy_n(power, count, powerOfAdded.begin());
    if (returns.powerOfEchoes) {
      multiply(returns.gain, first, count, power);
      if (o_.reflectivity) removeRangeLoss(range, count, power, reflectivity);
    } else {
      setPowerOfHits(hits, lobes, first, count, returns, reflectivity);
    }
    for (std::size_t i = 0; i < count && !returns.onePerBeam(); ++i) {
      if (returns.hit(first + i) != kNoHit) continue;
      const float gain = returns.gain.empty() ? 1 : returns.gain[first + i];
      reflectivity[i] = power[i] = powerOfAdded[i] * gain;
      applyRangeLoss(range + i, 1, power + i);
    }
    clampPower(range, count, power);
    if (o_.reflectivity) clampPower(range, count, reflectivity);
  }

  // Does the work of setPower() for rows that are hits. The loss follows from the range of the hit, because earlier
  // effects may have changed the range of the row.
  void setPowerOfHits(const Hits& hits, const std::vector<Lobes>& lobes, std::size_t first, std::size_t count,
                      Returns& returns, float* reflectivity) const {
    float* const power = returns.power.data() + first;
    setReflected(hits, returns, first, lobes, count, power);
    multiply(returns.gain, first, count, power);
    if (o_.reflectivity) std::copy_n(power, count, reflectivity);
    Batch<float> rangesOfHits;
    applyRangeLoss(valuesOfHits(returns, hits.range, first, rangesOfHits, kMiss), count, power);
  }

  // Sets the intensity of a batch of rows from their power or from `reflectivity`, which may be overwritten.
  void report(const Shot& shot, std::size_t first, std::size_t count, Returns& returns, float* reflectivity) const {
    const float* const power = returns.power.data() + first;
    float* const intensity = returns.intensity.data() + first;
    const float* value = o_.reflectivity ? reflectivity : power;
    if (!o_.rangeResponse.empty()) {
      const float* const range = returns.range.data() + first;
      for (std::size_t i = 0; i < count; ++i) {
        reflectivity[i] = value[i] * static_cast<float>(interpolated(o_.rangeResponse, range[i]));
      }
      value = reflectivity;
    }
    if (o_.floor > 0) {
      subtractFloor(value, power, count, reflectivity);
      value = reflectivity;
    }
    respond(value, count, intensity);
    if (o_.noise > 0) addNoise(shot, returns, first, count);
    round(count, intensity);
  }

  // Multiplies the power of a batch of rows by the rows' factors. An empty `factors` leaves the power unchanged.
  static void multiply(const std::vector<float>& factors, std::size_t first, std::size_t count, float* power) {
    for (std::size_t i = 0; i < count && !factors.empty(); ++i) power[i] *= factors[first + i];
  }

  // Limits the power to finite values, and sets it to 0 if it is negative or NaN, or if the row has no return.
  static void clampPower(const float* range, std::size_t count, float* power) {
    for (std::size_t i = 0; i < count; ++i) {
      const float finite = power[i] < FLT_MAX ? power[i] : FLT_MAX;
      power[i] = range[i] < kMiss && power[i] > 0 ? finite : 0;
    }
  }

  // Sets `power` to the light that the surfaces of a batch of rows reflect back along the beam. `lobes`: see
  // lobesOfAll().
  void setReflected(const Hits& hits, const Returns& returns, std::size_t first, const std::vector<Lobes>& lobes,
                    std::size_t count, float* power) const {
    const auto valuesOf = [&](const std::vector<float>& values, Batch<float>& buffer) {
      return values.empty() ? nullptr : valuesOfHits(returns, values, first, buffer);
    };
    // Properties of the batch's rows. roughness, metallic and retro are null if the materials' values apply.
    Batch<std::uint16_t> materials;
    Batch<float> reflectances, incidences, roughnesses, metals, retros;
    const std::uint16_t* const material = valuesOfHits(returns, hits.material, first, materials);
    const float* const reflectance = valuesOf(hits.reflectance, reflectances);
    const float* const incidence = valuesOf(hits.incidence, incidences);
    const float* const roughness = valuesOf(hits.roughness, roughnesses);
    const float* const metallic = valuesOf(hits.metallic, metals);
    const float* const retro = valuesOf(hits.retroreflectance, retros);
    if (roughness != nullptr) {
      for (std::size_t i = 0; i < count; ++i) {
        const Lobes lobe = lobesOf(roughness[i], metallic[i], retro[i], o_.orenNayar);
        power[i] = reflected(lobe, incidence[i], reflectance[i]);
      }
      return;
    }
    const Lobes* const table = lobes.data();
    const std::uint32_t noMaterial = static_cast<std::uint32_t>(lobes.size() - 1);
    const auto lobesOfRow = [&](std::size_t i) { return table[std::min<std::uint32_t>(material[i], noMaterial)]; };
    // Neighbouring rays often hit the same material. For such a group the first loop over k, which is vectorised, is
    // enough; for other groups the second loop replaces its results.
    constexpr std::size_t kRowGroup = 16;
    std::size_t i = 0;
    for (; i + kRowGroup <= count; i += kRowGroup) {
      std::uint32_t differences = 0;  // bits in which a material's index differs from the first row's
      for (std::size_t k = 0; k < kRowGroup; ++k) differences |= material[i + k] ^ material[i];
      std::array<float, kRowGroup> group;
      const Lobes lobe = lobesOfRow(i);
      for (std::size_t k = 0; k < kRowGroup; ++k) group[k] = reflected(lobe, incidence[i + k], reflectance[i + k]);
      for (std::size_t k = 0; k < kRowGroup && differences != 0; ++k) {
        group[k] = reflected(lobesOfRow(i + k), incidence[i + k], reflectance[i + k]);
      }
      std::copy_n(group.begin(), kRowGroup, power + i);
    }
    for (; i < count; ++i) power[i] = reflected(lobesOfRow(i), incidence[i], reflectance[i]);
  }

  // Reverses applyRangeLoss(): sets `reflectivity` to `power` divided by the loss or, if the loss is 0, to `power`.
  void removeRangeLoss(const float* range, std::size_t count, const float* power, float* reflectivity) const {
    Batch<float> loss;
    loss.fill(1);
    applyRangeLoss(range, count, loss.data());
    for (std::size_t i = 0; i < count; ++i) reflectivity[i] = loss[i] > 0 ? power[i] / loss[i] : power[i];
  }

  // Converts powers at the reference range in clear air to powers at each echo's range: multiplies them by (reference
  // range / max(range, near range))^2, if the falloff is inverse-square, and by the two-way transmission of the air.
  void applyRangeLoss(const float* range, std::size_t count, float* power) const {
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

  // Sets `result` to `value` times the fraction of the received power that exceeds the floor. `result` may be `value`.
  void subtractFloor(const float* value, const float* power, std::size_t count, float* result) const {
    for (std::size_t i = 0; i < count; ++i) {
      result[i] = value[i] * (1 - o_.floor / (power[i] > o_.floor ? power[i] : o_.floor));
    }
  }

  // Converts values (power or reflectivity) to intensities before noise and rounding, by one of three responses: a
  // table, the scale of calibrated reflectivity, or gain, saturation and gamma.
  void respond(const float* value, std::size_t count, float* intensity) const {
    if (!o_.table.empty()) return respondByTable(value, count, intensity);
    if (o_.retroFullScale > 0) return respondCalibrated(value, count, intensity);
    const float scale = o_.bytes ? 1 / o_.saturation : 1.0f;
    for (std::size_t i = 0; i < count; ++i) {
      const float amplified = o_.gain * value[i];
      intensity[i] = (amplified < o_.saturation ? amplified : o_.saturation) * scale;
    }
    if (o_.gamma != 1) {
      for (std::size_t i = 0; i < count; ++i) {
        const double base = intensity[i] > FLT_MIN ? intensity[i] : FLT_MIN;
        double power = exponential(o_.gamma * naturalLog(base));
        power = power < FLT_MAX ? power : FLT_MAX;
        intensity[i] = intensity[i] > FLT_MIN ? static_cast<float>(power) : 0.0f;
      }
    }
    for (std::size_t i = 0; i < count && o_.bytes; ++i) intensity[i] *= 255;
  }

  // Converts values to bytes of calibrated reflectivity: 0 to 100 for diffuse surfaces, 100 to 255 for retroreflectors.
  void respondCalibrated(const float* value, std::size_t count, float* intensity) const {
    const double stepsPerLog = 155 / naturalLog(o_.retroFullScale);
    for (std::size_t i = 0; i < count; ++i) {
      const double amplified = o_.gain * value[i];
      const double diffuse = amplified < 1 ? amplified : 1.0;
      const double logOfRetro = amplified > 1 ? naturalLog(amplified) : 0.0;
      intensity[i] = static_cast<float>(100 * diffuse + stepsPerLog * logOfRetro);
    }
  }

  void respondByTable(const float* value, std::size_t count, float* intensity) const {
    for (std::size_t i = 0; i < count; ++i) {
      intensity[i] = value[i] > FLT_MIN ? static_cast<float>(interpolated(o_.table, value[i])) : 0.0f;
    }
  }

  // Adds the noise to intensities above 0.
  void addNoise(const Shot& shot, Returns& returns, std::size_t first, std::size_t count) const {
    RandomWords words;
    drawWords(shot, Purpose::IntensityNoise, returns, first, words);
    const double sigma = o_.noise * intensityFullScale();
    float* const intensity = returns.intensity.data() + first;
    for (std::size_t i = 0; i < count; ++i) {
      const double noisy = intensity[i] + sigma * normalPair(words.a[i], words.b[i]).first;
      const double notNegative = noisy > 0 ? noisy : 0;
      intensity[i] = intensity[i] > 0 ? static_cast<float>(notNegative) : 0.0f;
    }
  }

  void round(std::size_t count, float* intensity) const {
    const double step = o_.step * intensityFullScale();
    for (std::size_t i = 0; i < count && step > 0; ++i) {
      intensity[i] = static_cast<float>(std::floor(intensity[i] / step + 0.5) * step);
    }
    for (std::size_t i = 0; i < count && o_.bytes; ++i) {
      const float rounded = std::floor(intensity[i] + 0.5f);
      intensity[i] = rounded < 255 ? rounded : 255.0f;
    }
  }

  IntensityOptions o_;
};

// Reads an option that is a list of pairs such as "[value, intensity]" (`pairNames`); empty if the option is absent.
// `most`: the largest second number of a pair.
LogTable readLogTable(const Fields& options, const char* key, const char* pairNames, double most) {
  const Value* const list = options.find(key);
  if (list == nullptr) return {};
  const std::string option = std::string("effect intensity: ") + key;
  if (list->kind != Value::Kind::Sequence || list->items.size() < 2) {
    throw InputError(list->where, "{} must be a list of at least two pairs {}", option, pairNames);
  }
  LogTable rows;
  for (const Value& item : list->items) {
    const std::vector<double> pair = readNumbers(item, option, {0, 1e30});
    if (pair.size() != 2) throw InputError(item.where, "{}: each row is {}", option, pairNames);
    const double logarithm = naturalLog(std::max(pair[0], 1e-30));
    if (pair[0] < 1e-30 || (!rows.empty() && logarithm <= rows.back().first)) {
      throw InputError(item.where, "{}: the first numbers must be above 0 and rise from row to row", option);
    }
    if (pair[1] > most) throw InputError(item.where, "{}: the second numbers must be at most {:g}", option, most);
    rows.emplace_back(logarithm, pair[1]);
  }
  return rows;
}

}  // namespace

std::unique_ptr<Effect> makeIntensity(Fields& options) {
  IntensityOptions o;
  o.referenceRange = static_cast<float>(options.number("reference_range_m", {0.1, 1000}, 10));
  o.nearRange = static_cast<float>(options.number("near_range_m", {0.001, 1000}, 1));
  o.inverseSquare = options.choice("falloff", {"inverse_square", "none"}, "inverse_square") == "inverse_square";
  o.attenuation = options.number("attenuation_per_m", {0, 10}, 0);
  o.gain = static_cast<float>(options.number("gain", {0, 1e9}, 1));
  o.bytes = options.choice("output", {"float", "u8"}, "float") == "u8";
  o.saturation = static_cast<float>(options.number("saturation", {1e-9, 1e30}, o.bytes ? 1.0 : 1e30));
  o.gamma = options.number("gamma", {0.05, 10}, 1);
  o.reflectivity = options.choice("model", {"power", "reflectivity"}, "power") == "reflectivity";
  o.orenNayar = options.choice("diffuse", {"lambertian", "oren_nayar"}, "lambertian") == "oren_nayar";
  const Value* retro = options.find("retro_full_scale");
  if (retro != nullptr) o.retroFullScale = options.number("retro_full_scale", {1.01, 1e9});
  const Value* table = options.find("table");
  o.table = readLogTable(options, "table", "[value, intensity]", o.bytes ? 255 : 1e30);
  o.rangeResponse = readLogTable(options, "range_response", "[range in m, factor]", 1e6);
  o.floor = static_cast<float>(options.number("floor", {0, 1e6}, 0));
  o.noise = options.number("noise", {0, 1}, 0);
  o.step = options.number("step", {0, 1}, 0);
  options.finish();
  for (const char* key : {"gain", "gamma", "saturation", "retro_full_scale"}) {
    if (table != nullptr && options.has(key)) {
      throw InputError(table->where, std::string("effect intensity: table is the complete response: leave out ") + key);
    }
  }
  if (retro != nullptr && (!o.reflectivity || !o.bytes)) {
    throw InputError(retro->where, "effect intensity: retro_full_scale needs `model: reflectivity` and `output: u8`");
  }
  if (retro != nullptr && (options.has("saturation") || options.has("gamma"))) {
    throw InputError(
        retro->where,
        "effect intensity: retro_full_scale defines the complete response: leave saturation and gamma out");
  }
  return std::make_unique<Intensity>(std::move(o));
}

}  // namespace scanmill
