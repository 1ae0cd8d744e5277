// weather: rain, snow, fog or dust between the sensor and the surfaces that it sees. docs/sensing.md explains the
// options and the limits of the model.
//
//   weather: {kind: rain, severity: moderate}      # or light, heavy
//   weather: {kind: rain, rate_mm_h: 12.5, wet: 0.6}
//   weather: {kind: fog, visibility_m: 80}
//
// The power of all returns is multiplied by exp(-2 extinction r), the air's transmission both ways, before detection.
// Particles in the air add returns with cause 6, in front of the nearest surface that the beam hits (physics:
// sense/weather.h).
//
// Raindrops and snowflakes are sparse: the number of sufficiently bright drops in a beam follows the Poisson
// distribution with the mean
//
//   integral of A(r) N(D > D_least(r)) dr,    D_least^2 = p_least A(r) w(r)^2 exp(2 extinction r) / dropEcho
//
// from the sensor to the surface, with w(r) = max(r, near_range_m) / reference_range_m from the options of the effect
// `intensity` (1 for `falloff: none`). A(r) is the area that the beam illuminates (beamArea() in sensors/footprint.h).
// N is the number of drops per volume. Drops of received power below p_least are ignored. A drop of diameter D has the
// echo dropEcho D^2 / A(r). Ranges are sampled from the integrand, and diameters from the size distribution above
// D_least: the result has exactly the distribution that sampling all drops in the beam would give. The area is treated
// as evenly lit, and each drop as completely inside or outside.
//
// Fog and dust are dense. A beam is divided into intervals of a pulse length. The echo of an interval is pi backscatter
// length exp(-2 extinction r), in units of a white target at the same range. If its received power is at least p_least,
// it becomes a return at a random range within the interval. A beam gets at most eight returns from particles: its
// strongest drops, or intervals sampled with probabilities proportional to their power.

#include "sense/weather.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "sense/effects/makers.h"
#include "sense/effects/spatial_noise.h"
#include "sensors/footprint.h"

namespace scanmill {
namespace {

constexpr double kUnitRange = 10;           // m; `least` is in units of a white target at this range
constexpr double kUsualLeastPower = 0.001;  // power below which particles are ignored
constexpr std::size_t kMostOfBeam = 8;      // largest number of a beam's drops or intervals that become returns
constexpr std::size_t kMostIntervals = 32;  // largest number of intervals of a beam, two per random block
constexpr std::uint32_t kMostDrops = 15;    // largest number of drops of a beam, one per random block
constexpr double kWetCosine = 0.5;          // least cosine of the angle between a wet surface's normal and the vertical
constexpr double kPuddleSize = 1.2;         // m, size of the patches of standing water

// Assumed for sensors whose files give no beam width or no pulse length: typical values of data sheets of spinning
// sensors (VLS-128: 3.0 x 1.5 mrad; HDL-64E: 2 mrad; OS1: 5.3 mrad to 1/e^2; pulses of 5 to 6 ns).
constexpr double kUsualDivergence = 3e-3;  // rad, full angle of a Gaussian beam to 1/e^2 of its power
constexpr double kUsualPulse = 5e-9;       // s

// Returns the area (m^2) that a beam illuminates at a range (m); assumes kUsualDivergence if no beam width is known.
double litArea(const BeamTable& beams, double range) {
  const double area = beamArea(beams, range);
  if (area > 0) return area;
  const double width = kUsualDivergence * range;
  return kPi / 8 * width * width;
}

struct WeatherOptions {
  Weather weather;
  double least = 0;         // power below which particles are ignored; 0: kUsualLeastPower, or less for receivers that
                            // detect fainter echoes
  double wet = 0;           // fraction of upward surfaces under standing water
  std::uint16_t label = 0;  // class of the particles' returns
};

// The properties of the receiver on which the returns of particles depend.
struct Reception {
  Falloff falloff;
  double least = 0;  // power below which particles are ignored
};

// A table of the expected number of sufficiently bright drops between the sensor and each of many ranges.
class DropTable {
 public:
  DropTable(const Weather& weather, const BeamTable& beams, const Reception& reception)
      : weather_(weather), beams_(beams), reception_(reception) {
    step_ = (beams.maxRange - beams.minRange) / kSteps;
    double startDensity = density(beams.minRange);
    for (std::size_t i = 1; i <= kSteps; ++i) {
      const double endDensity = density(beams.minRange + static_cast<double>(i) * step_);
      sum_[i] = sum_[i - 1] + (startDensity + endDensity) / 2 * step_;
      startDensity = endDensity;
    }
  }

  // Returns the expected number of sufficiently bright drops from the minimum range to `range` (m).
  double expectedDrops(double range) const {
    const double position = std::clamp((range - beams_.minRange) / step_, 0.0, double{kSteps});  // in steps
    const auto i = std::min(static_cast<std::size_t>(position), kSteps - 1);
    return sum_[i] + (position - static_cast<double>(i)) * (sum_[i + 1] - sum_[i]);
  }

  // Returns the range (m) for which expectedDrops() is `count`.
  double rangeOf(double count) const {
    const auto next = std::upper_bound(sum_.begin() + 1, sum_.end() - 1, count);
    const double previous = *(next - 1);
    const double fraction = *next > previous ? std::clamp((count - previous) / (*next - previous), 0.0, 1.0) : 0.0;
    return beams_.minRange + (static_cast<double>(next - sum_.begin()) - 1 + fraction) * step_;
  }

  // Returns the diameter (mm) of the smallest drop that is bright enough at a range (m).
  double leastDiameter(double range) const {
    const double loss = reception_.falloff.amplitudeLoss(range);
    const double area = litArea(beams_, range);
    return std::sqrt(reception_.least * area * loss * loss * exponential(2 * weather_.extinction * range) /
                     weather_.dropEcho);
  }

 private:
  static constexpr std::size_t kSteps = 4096;

  // Returns the expected number of sufficiently bright drops per metre of a beam at a range (m).
  double density(double range) const { return litArea(beams_, range) * weather_.drops.above(leastDiameter(range)); }

  const Weather& weather_;
  const BeamTable& beams_;
  Reception reception_;
  double step_ = 0;                       // m of range, from entry to entry of sum_
  std::array<double, kSteps + 1> sum_{};  // expected numbers of drops from the minimum range on
};

// Returns for each beam the range (m) up to which nothing blocks it: the range of its nearest return, or the sensor's
// maximum range if the beam has no return.
std::vector<float> openRanges(const Hits& hits, const BeamTable& beams, const Returns& returns) {
  std::vector<float> open(hits.size(), static_cast<float>(beams.maxRange));
  for (std::size_t row = 0; row < returns.size(); ++row) {
    float& openRange = open[returns.beam(row)];
    if (returns.returned(row)) openRange = std::min(openRange, returns.range[row]);
  }
  // A beam that the ego vehicle blocks nearer than the sensor's minimum range has no hit; its open range is 0.
  for (std::size_t ray = 0; ray < hits.pathOfRay.size(); ++ray) {
    if (hits.pathOfRay[ray] != RayPath::EgoVehicle || hits.hit(ray)) continue;
    open[hits.beamOfRay.empty() ? ray : hits.beamOfRay[ray]] = 0;
  }
  return open;
}

struct Particle {
  float range;     // m
  float echo;      // power relative to a white target at the same range, after the loss in the air
  float strength;  // power as received, see Falloff
  float rank;      // in beams with too many particles, those with the highest ranks become returns
};

class WeatherEffect : public Effect {
 public:
  explicit WeatherEffect(const WeatherOptions& options) : o_(options) {}

  Channels reads() const override {
    const Channels hits = Channel::Range;
    return o_.wet > 0 ? hits | Channel::Normal | Channel::Reflectance | Channels(Channel::Incidence) : hits;
  }
  bool setsGain() const override { return true; }
  std::uint32_t mostReturns(std::uint32_t before) const override {
    return std::min(before + static_cast<std::uint32_t>(kMostOfBeam), kMostReturns);
  }

  std::string assumed(const BeamTable& beams) const override {
    std::string keys;
    if (beamArea(beams, 1) == 0) keys = fmt::format("`divergence_mrad: {:g}`", kUsualDivergence * 1e3);
    if (beams.pulse == 0) {
      keys += fmt::format("{}`pulse_ns: {:g}`", keys.empty() ? "" : " and ", kUsualPulse * 1e9);
    }
    return keys;
  }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    returns.gain.resize(returns.size(), 1.0f);
    const std::vector<float> open = openRanges(hits, *shot.beams, returns);
    extinguish(returns);
    if (o_.wet > 0) wetGround(hits, shot, returns);
    const Falloff& falloff = returns.falloff;
    // Converts the least power from the unit of `least`, a white target at kUnitRange, to the unit of the effect
    // `intensity`, a white target at falloff.reference. In noise, some echoes of half the threshold are detected.
    const double rangeRatio = falloff.inverseSquare ? falloff.reference / kUnitRange : 1;
    Reception reception{.falloff = falloff,
                        .least = (o_.least > 0 ? o_.least : kUsualLeastPower) * rangeRatio * rangeRatio};
    if (o_.least == 0 && returns.threshold > 0) reception.least = std::min(reception.least, returns.threshold / 2);
    if (o_.weather.drops.intercept > 0) addDrops(hits, shot, open, reception, returns);
    if (o_.weather.backscatter > 0) addMist(hits, shot, open, reception, returns);
  }

 private:
  // Multiplies the gain of each row by the fraction of light that the air transmits, both ways.
  void extinguish(Returns& returns) const {
    if (returns.recordsReasons()) returns.air.resize(returns.size(), 1.0f);
    for (std::size_t row = 0; row < returns.size(); ++row) {
      if (!returns.returned(row)) continue;
      const auto transmitted = static_cast<float>(exponential(-2 * o_.weather.extinction * returns.range[row]));
      returns.gain[row] *= transmitted;
      if (returns.recordsReasons()) returns.air[row] *= transmitted;
    }
  }

  // Multiplies the gain of rows whose surfaces face upwards: wet surfaces are darker, and puddles transmit less light.
  // Puddles are the points where a Gaussian field is below its quantile for the fraction `wet`.
  void wetGround(const Hits& hits, const Shot& shot, Returns& returns) const {
    const double puddleBound = quantileOfNormal(o_.wet);
    const PositionsOfHits positionsOfHits(hits, shot, returns);
    SpatialField puddles(shot.seed, Purpose::WetGround, 0);
    Positions positions;
    Batch<double> cubesPerMetre, factorOne;
    cubesPerMetre.fill(1 / kPuddleSize);
    factorOne.fill(1);
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      Batch<double> field{};
      positionsOfHits.compute(first, positions);
      puddles.add(positions, cubesPerMetre, factorOne, field);
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t hit = returns.hit(first + i);
        if (!returns.returned(first + i) || hit == kNoHit || double{hits.normal[hit].z} < kWetCosine) continue;
        double factor = dampness(std::clamp(double{hits.reflectance[hit]}, 0.0, 1.0));
        if (field[i] < puddleBound) factor *= filmTransmission(hits.incidence[hit]);
        returns.gain[first + i] *= static_cast<float>(factor);
      }
    });
  }

  // Returns the quantile of the standard normal distribution for a probability, found by bisection.
  static double quantileOfNormal(double probability) {
    double low = -8, high = 8;
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2;
      (std::erfc(-middle / std::sqrt(2.0)) / 2 < probability ? low : high) = middle;
    }
    return low;
  }

  // Adds the returns of raindrops or snowflakes. `open`: see openRanges().
  void addDrops(const Hits& hits, const Shot& shot, const std::vector<float>& open, const Reception& reception,
                Returns& returns) const {
    const BeamTable& beams = *shot.beams;
    const DropTable table(o_.weather, beams, reception);
    std::vector<Particle> drops;
    for (std::uint32_t beam = 0; beam < beams.size(); ++beam) {
      const double expected = table.expectedDrops(double{open[beam]});
      if (expected <= 0) continue;
      // The number of drops has Poisson's distribution, which is inverted by subtracting the probabilities of 0, 1, 2
      // ... drops from a uniform number. The uniform number comes from the random block after the drops' blocks.
      double remainder = uniform(drawBlock(shot, Purpose::Weather, beam, kMostDrops)[0]);
      double probability = exponential(-expected);  // probability of n drops
      drops.clear();
      for (std::uint32_t n = 0; remainder > probability && n < kMostDrops; ++n) {
        remainder -= probability;
        probability *= expected / (n + 1);
        const RandomBlock words = drawBlock(shot, Purpose::Weather, beam, n);
        const double range = table.rangeOf(expected * uniform(words[0]));
        const double diameter = table.leastDiameter(range) - naturalLog(uniform(words[1])) / o_.weather.drops.slope;
        const double area = litArea(beams, range);
        drops.push_back(
            particleAt(range, std::min(1.0, o_.weather.dropEcho * diameter * diameter / area), reception.falloff));
      }
      addParticles(beam, drops, hits, returns);
    }
  }

  // Adds the returns of fog or dust. A beam is divided into intervals of one pulse length, each of which may give an
  // echo. `open`: see openRanges().
  void addMist(const Hits& hits, const Shot& shot, const std::vector<float>& open, const Reception& reception,
               Returns& returns) const {
    const BeamTable& beams = *shot.beams;
    const double pulse = pulseLength(beams.pulse > 0 ? beams.pulse : kUsualPulse);  // m
    std::vector<Particle> intervals;
    for (std::uint32_t beam = 0; beam < beams.size(); ++beam) {
      intervals.clear();
      RandomBlock words{};
      for (std::uint32_t k = 0; k < kMostIntervals; ++k) {
        const double start = beams.minRange + k * pulse;
        const double length = std::min(pulse, double{open[beam]} - start);
        if (length <= 0) break;
        if (k % 2 == 0) words = drawBlock(shot, Purpose::Fog, beam, k / 2);
        const double range = start + length * uniform(words[2 * (k % 2) + 1]);
        Particle interval = particleAt(range, mistEcho(o_.weather, length), reception.falloff);
        if (double{interval.strength} < reception.least) break;
        // The intervals of largest rank are a sample with probabilities proportional to the strength (Efraimidis and
        // Spirakis, "Weighted random sampling with a reservoir", Information Processing Letters 97, 2006).
        interval.rank /= static_cast<float>(-naturalLog(uniform(words[2 * (k % 2)])));
        intervals.push_back(interval);
      }
      addParticles(beam, intervals, hits, returns);
    }
  }

  // Returns a particle at a range (m). `echo`: its power relative to a white target at this range, in clear air.
  Particle particleAt(double range, double echo, const Falloff& falloff) const {
    const double echoBehindAir = echo * exponential(-2 * o_.weather.extinction * range);
    const double loss = falloff.amplitudeLoss(range);
    const auto strength = static_cast<float>(echoBehindAir / (loss * loss));
    return {static_cast<float>(range), static_cast<float>(echoBehindAir), strength, strength};
  }

  // Adds a beam's particles as returns: at most kMostOfBeam, those with the highest ranks.
  void addParticles(std::uint32_t beam, std::vector<Particle>& particles, const Hits& hits, Returns& returns) const {
    if (particles.size() > kMostOfBeam) {
      std::nth_element(particles.begin(), particles.begin() + kMostOfBeam, particles.end(),
                       [](const Particle& a, const Particle& b) { return a.rank > b.rank; });
      particles.resize(kMostOfBeam);
    }
    for (const Particle& particle : particles) {
      if (returns.full(beam)) return;
      returns.add(
          {.beam = beam, .range = particle.range, .power = particle.echo, .cause = Reason::Weather, .label = o_.label},
          hits);
    }
  }

  WeatherOptions o_;
};

struct Severity {
  double amount;  // rate (mm/h of water) or visibility (m)
  double wet;     // fraction of the ground under standing water
};

struct KindOfWeather {
  std::string_view name;
  Weather (*weatherOf)(double amount);
  const char* amountKey;               // the option that states the amount
  const char* otherKey;                // the option that states the amount of other kinds
  Range amounts;                       // limits of the amount
  std::array<Severity, 3> severities;  // light, moderate, heavy
};

// The severities follow the bounds that observers use: for rain the rate (2.5 and 7.6 mm/h, glossary of the American
// Meteorological Society), for snow the visibility (1000 and 500 m), and for fog the visibility (1000 and 200 m). The
// values within these bounds, and the fractions under water, are estimates.
constexpr std::array<KindOfWeather, 4> kKinds{{
    {"rain", rainOf, "rate_mm_h", "visibility_m", {0.01, 200}, {{{1.5, 0.1}, {5, 0.3}, {25, 0.6}}}},
    {"snow", snowOf, "rate_mm_h", "visibility_m", {0.01, 50}, {{{0.5, 0}, {1.5, 0}, {4, 0}}}},
    {"fog", fogOf, "visibility_m", "rate_mm_h", {1, 1e5}, {{{500, 0}, {150, 0}, {50, 0}}}},
    {"dust", dustOf, "visibility_m", "rate_mm_h", {1, 1e5}, {{{500, 0}, {150, 0}, {50, 0}}}},
}};

}  // namespace

std::unique_ptr<Effect> makeWeather(Fields& options) {
  options.also({"kind", "severity", "rate_mm_h", "visibility_m", "wet", "least", "label"}).finish();
  options.require("kind");
  const std::string name = options.choice("kind", namesOf(kKinds), "");
  const KindOfWeather& kind = *std::ranges::find(kKinds, name, &KindOfWeather::name);
  if (const Value* amount = options.find(kind.otherKey)) {
    throw InputError(amount->where, fmt::format("effect weather: give the amount of {} by `{}`", name, kind.amountKey));
  }
  const std::string word = options.choice("severity", {"light", "moderate", "heavy"}, "moderate");
  Severity severity = kind.severities[word == "light" ? 0 : word == "moderate" ? 1 : 2];
  if (const Value* amount = options.find(kind.amountKey)) {
    if (options.has("severity")) {
      throw InputError(amount->where, fmt::format("effect weather: give `severity` or `{}`, not both", kind.amountKey));
    }
    severity.amount = options.number(kind.amountKey, kind.amounts);
  }
  WeatherOptions o;
  o.weather = kind.weatherOf(severity.amount);
  o.wet = options.number("wet", {0, 1}, severity.wet);
  if (options.has("least")) o.least = options.number("least", {1e-6, 1});
  o.label = static_cast<std::uint16_t>(options.integer("label", 0, 65535, 0));
  options.finish();
  return std::make_unique<WeatherEffect>(o);
}

}  // namespace scanmill
