// detection: which echoes the receiver detects in its noise, and which of the detected echoes it reports.
// docs/sensing.md explains the options.
//
//   detection: {returns: strongest}                 # or first, last, dual (strongest and last), all, or a number
//   detection: {returns: dual, noise: 0.0008, threshold: 4.8, min_separation_m: 1}
//
// `noise` is the standard deviation of the receiver's noise, in the unit of the power that the effect `intensity`
// computes. An echo of power P is measured as P + noise * n, with a standard normal number n, and detected if the
// measured power is at least threshold * noise. The probability of detection is
//
//   Pd = Q(threshold - P / noise),    Q(x) = erfc(x / sqrt 2) / 2
//
// (Skolnik, "Introduction to Radar Systems", 1981, section 2.5, for a signal of known phase in Gaussian noise, which
// applies to pulses without a carrier). The receiver resolves (farthest - nearest) / (c pulse / 2) intervals of range;
// in each interval, noise alone exceeds the threshold with the probability Q(threshold). These false positives have a
// uniformly random range, cause 2 (FalsePositive), no class and intensity 0.
//
// sun: {azimuth_deg, elevation_deg, noise}: noise^2 + sun.noise^2 R max(0, n . s) replaces noise^2, for a surface of
// reflectance R and normal n, and the direction s to the sun (world frame), since the shot noise of light is
// proportional to the square root of the light's power. Shadows are not traced.
//
// interference: the probability, per beam, of a return from another sensor's pulse. Such a return has cause 7
// (StrayLight), a uniformly random range, and a power from the threshold to 100 times the threshold, uniformly random
// in its logarithm.
//
// The detected echoes of a beam are visited by descending power. An echo is removed if it is nearer than
// min_separation_m to a stronger echo that was kept. `returns` selects from the kept echoes: dual reports the strongest
// and the last or, if one echo is both, the two strongest (as Velodyne's sensors do); n reports the n strongest.

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"
#include "sensors/footprint.h"

namespace scanmill {
namespace {

enum class Report { Strongest, First, Last, Dual };

struct DetectionOptions {
  Report report = Report::Strongest;
  std::uint32_t most = 1;  // largest number of echoes that Report::Strongest reports for a beam
  double noise = 0;        // standard deviation, in units of power
  double threshold = 4.8;  // least signal that is detected, in units of the noise
  float separation = 0;    // m, least distance between reported echoes
  bool sun = false;
  Vec3d towardsSun;         // unit vector, world axes
  double sunNoise = 0;      // noise that a white surface facing the sun adds
  double interference = 0;  // probability per beam
};

class Detection : public Effect {
 public:
  Detection(const DetectionOptions& options, Location where) : o_(options), where_(std::move(where)) {}

  Channels reads() const override {
    return o_.sun ? Channel::Range | Channel::Normal | Channels(Channel::Reflectance) : Channels(Channel::Range);
  }
  // Reporting the first, the last or all echoes does not need the intensity.
  bool needsIntensity() const override {
    return o_.noise > 0 || o_.separation > 0 || o_.report == Report::Dual ||
           (o_.report == Report::Strongest && o_.most < kMostReturns);
  }
  bool setsSnr() const override { return o_.noise > 0; }
  double threshold() const override { return o_.threshold * o_.noise; }
  std::uint32_t mostReturns(std::uint32_t before) const override {
    const std::uint32_t detected =
        std::min(before + (o_.noise > 0 ? 1 : 0) + (o_.interference > 0 ? 1 : 0), kMostReturns);
    return std::min(detected, o_.report == Report::Dual ? 2 : o_.report == Report::Strongest ? o_.most : 1);
  }

  void check(const BeamTable& beams) const override {
    if (o_.noise == 0 || beams.pulse > 0) return;
    throw InputError(where_,
                     "effect detection: the rate of false positives depends on the length of the pulse: add `pulse_ns: "
                     "5`, with the data sheet's value, to the sensor");
  }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    std::vector<float> measured = returns.power;  // by row: power with the receiver's noise
    if (o_.noise > 0) {
      std::vector<float> noise;
      if (o_.sun) noise = noiseInDaylight(hits, returns);
      detectInNoise(shot, noise, returns, measured);
      returns.recordFaint(measured, static_cast<float>(o_.threshold * o_.noise));
      addFalsePositives(hits, shot, returns, measured);
      if (o_.interference > 0) addInterference(hits, shot, returns, measured);
    }
    if (!returns.onePerBeam()) selectReported(returns, measured);
    for (std::size_t row = 0; row < returns.intensity.size(); ++row) {
      if (!returns.returned(row)) returns.intensity[row] = 0;
    }
  }

 private:
  // Returns the standard deviation of each row's noise, which includes the shot noise of sunlight.
  std::vector<float> noiseInDaylight(const Hits& hits, const Returns& returns) const {
    std::vector<float> noise(returns.size(), static_cast<float>(o_.noise));
    for (std::size_t row = 0; row < returns.size(); ++row) {
      const std::uint32_t hit = returns.hit(row);
      if (hit == kNoHit || !returns.returned(row)) continue;
      const double sunCosine = std::max(0.0, dot(Vec3d(hits.normal[hit]), o_.towardsSun));
      const double daylight = sunCosine * double{hits.reflectance[hit]};  // relative to a white surface facing the sun
      noise[row] = static_cast<float>(std::sqrt(o_.noise * o_.noise + o_.sunNoise * o_.sunNoise * daylight));
    }
    return noise;
  }

  // Removes the rows of echoes that are not detected, and sets the signal to noise ratio and the measured power of all
  // rows. `noiseOfRow`: the noise of each row; if it is empty, all rows have the same noise.
  SCANMILL_BEST_INSTRUCTIONS void detectInNoise(const Shot& shot, const std::vector<float>& noiseOfRow,
                                                Returns& returns, std::vector<float>& measured) const {
    returns.snr.assign(returns.size(), 0);
    RandomWords words;
    Batch<float> noise;
    noise.fill(static_cast<float>(o_.noise));
    Batch<float> leastPower;
    leastPower.fill(static_cast<float>(o_.threshold * o_.noise));
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      drawWords(shot, Purpose::Detection, returns, first, words);
      float* const range = returns.range.data() + first;
      float* const snr = returns.snr.data() + first;
      float* const measure = measured.data() + first;
      const float* const power = returns.power.data() + first;
      for (std::size_t i = 0; i < count && !noiseOfRow.empty(); ++i) {
        noise[i] = noiseOfRow[first + i];
        leastPower[i] = static_cast<float>(o_.threshold * double{noise[i]});
      }
      for (std::size_t i = 0; i < count; ++i) {
        snr[i] = power[i] / noise[i];
        measure[i] = power[i] + noise[i] * static_cast<float>(normalPair(words.a[i], words.b[i]).first);
        range[i] = measure[i] < leastPower[i] ? kMiss : range[i];
      }
    });
  }

  // Adds at most one false positive per beam as a row, and appends its power to `measured`. The excess of the power
  // over the threshold follows the tail of the normal distribution, which is nearly exponential there.
  void addFalsePositives(const Hits& hits, const Shot& shot, Returns& returns, std::vector<float>& measured) const {
    const BeamTable& beams = *shot.beams;
    const double rangeSpan = beams.maxRange - beams.minRange;
    const double probabilityPerInterval = 0.5 * std::erfc(o_.threshold / std::sqrt(2.0));
    const double expectedCount = rangeSpan / pulseLength(beams.pulse) * probabilityPerInterval;
    const double probability = -std::expm1(-expectedCount);
    Batch<std::uint32_t> firstWords;
    for (std::size_t first = 0; first < beams.size(); first += kBatch) {
      drawFirstWords(shot, first, firstWords);
      const std::size_t count = std::min(kBatch, beams.size() - first);
      for (std::size_t i = 0; i < count; ++i) {
        const auto beam = static_cast<std::uint32_t>(first + i);
        if (uniform(firstWords[i]) >= probability || returns.full(beam)) continue;
        const RandomBlock words = drawBlock(shot, Purpose::FalsePositives, beam);
        const double excess = o_.threshold > 0 ? -naturalLog(uniform(words[2])) / o_.threshold : 0.0;
        const AddedReturn added{.beam = beam,
                                .range = static_cast<float>(beams.minRange + rangeSpan * uniform(words[1])),
                                .power = static_cast<float>(o_.noise * (o_.threshold + excess)),
                                .snr = static_cast<float>(o_.threshold + excess)};
        returns.add(added, hits);
        measured.push_back(added.power);
      }
    }
  }

  // Adds the returns from pulses of other sensors as rows, and appends their power to `measured`.
  void addInterference(const Hits& hits, const Shot& shot, Returns& returns, std::vector<float>& measured) const {
    const BeamTable& beams = *shot.beams;
    for (std::uint32_t beam = 0; beam < beams.size(); ++beam) {
      const RandomBlock words = drawBlock(shot, Purpose::Interference, beam);
      if (uniform(words[0]) >= o_.interference || returns.full(beam)) continue;
      constexpr double kLog100 = 4.605170185988092;
      const double range = beams.minRange + (beams.maxRange - beams.minRange) * uniform(words[1]);
      const auto snr = static_cast<float>(o_.threshold * exponential(kLog100 * uniform(words[2])));
      const AddedReturn added{.beam = beam,
                              .range = static_cast<float>(range),
                              .power = static_cast<float>(o_.noise * double{snr}),
                              .snr = snr,
                              .cause = Reason::StrayLight};
      returns.add(added, hits);
      measured.push_back(added.power);
    }
  }

  // Sets `words` to the first random word of each beam of a batch.
  SCANMILL_BEST_INSTRUCTIONS static void drawFirstWords(const Shot& shot, std::size_t first,
                                                        Batch<std::uint32_t>& words) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      words[i] = drawBlock(shot, Purpose::FalsePositives, static_cast<std::uint32_t>(first + i))[0];
    }
  }

  // Removes the returns that are not reported. `measured`: power by row; if it is empty, all powers are equal.
  void selectReported(Returns& returns, const std::vector<float>& measured) const {
    std::vector<std::uint32_t> rows;  // rows with a return; after the sorting, the rows of a beam are adjacent
    for (std::uint32_t row = 0; row < returns.size(); ++row) {
      if (returns.returned(row)) rows.push_back(row);
    }
    // Sorts by beam. Only the few rows that effects have added are out of order.
    const auto isOfEarlierBeam = [&](std::uint32_t a, std::uint32_t b) { return returns.beam(a) < returns.beam(b); };
    const auto firstAdded = std::is_sorted_until(rows.begin(), rows.end(), isOfEarlierBeam);
    std::sort(firstAdded, rows.end(), isOfEarlierBeam);
    std::inplace_merge(rows.begin(), firstAdded, rows.end(), isOfEarlierBeam);
    // Orders a beam's rows by descending power, and at equal power by ascending range.
    const auto power = [&](std::uint32_t row) { return measured.empty() ? 0.0f : measured[row]; };
    const auto precedes = [&](std::uint32_t a, std::uint32_t b) {
      if (power(a) != power(b)) return power(a) > power(b);
      return returns.range[a] != returns.range[b] ? returns.range[a] < returns.range[b] : a < b;
    };
    for (std::size_t first = 0; first < rows.size();) {
      std::size_t end = first + 1;
      while (end < rows.size() && returns.beam(rows[end]) == returns.beam(rows[first])) ++end;
      const std::span<std::uint32_t> ofBeam{rows.data() + first, end - first};
      if (ofBeam.size() > 1) {
        std::ranges::sort(ofBeam, precedes);
        removeUnreported(ofBeam, returns);
      }
      first = end;
    }
  }

  // Removes the rows of one beam that are not reported. Reorders `rows`, which has the beam's rows by descending power.
  void removeUnreported(std::span<std::uint32_t> rows, Returns& returns) const {
    std::size_t count = 1;  // number of rows kept so far, which are moved to the front of `rows`
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const bool near = std::any_of(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(count), [&](auto row) {
        return std::abs(returns.range[row] - returns.range[rows[i]]) < o_.separation;
      });
      if (near) {
        returns.remove(rows[i]);
      } else {
        rows[count++] = rows[i];
      }
    }
    const std::span<std::uint32_t> separate = rows.first(count);
    const auto rangeOf = [&](std::uint32_t row) { return returns.range[row]; };
    const std::uint32_t nearest = *std::ranges::min_element(separate, {}, rangeOf);
    const std::uint32_t farthest = *std::ranges::max_element(separate, {}, rangeOf);
    const std::uint32_t strongest = separate.front();
    for (std::size_t rank = 0; rank < count; ++rank) {
      const std::uint32_t row = separate[rank];
      const bool reported = o_.report == Report::First  ? row == nearest
                            : o_.report == Report::Last ? row == farthest
                            : o_.report == Report::Dual
                                ? rank == 0 || row == farthest || (rank == 1 && farthest == strongest)
                                : rank < o_.most;
      if (!reported) returns.remove(row);
    }
  }

  DetectionOptions o_;
  Location where_;
};

}  // namespace

std::unique_ptr<Effect> makeDetection(Fields& options) {
  DetectionOptions o;
  const Value* returns = options.find("returns");
  const std::string word = returns == nullptr ? "strongest" : returns->text;
  if (!word.empty() && word.find_first_not_of("0123456789") == std::string::npos) {
    o.most = static_cast<std::uint32_t>(options.integer("returns", 1, kMostReturns));
  } else {
    const std::string chosen = options.choice("returns", {"strongest", "first", "last", "dual", "all"}, "strongest");
    o.report = chosen == "first"  ? Report::First
               : chosen == "last" ? Report::Last
               : chosen == "dual" ? Report::Dual
                                  : Report::Strongest;
    o.most = chosen == "all" ? kMostReturns : 1;
  }
  o.noise = options.number("noise", {0, 1e6}, 0);
  o.threshold = options.number("threshold", {0, 100}, 4.8);
  o.separation = static_cast<float>(options.number("min_separation_m", {0, 1000}, 0));
  o.interference = options.number("interference", {0, 1}, 0);
  if (const Value* sun = options.find("sun")) {
    Fields keys(*sun, "sun");
    const double azimuth = radians(keys.number("azimuth_deg", {-360, 360}));
    const double elevation = radians(keys.number("elevation_deg", {-90, 90}));
    o.sunNoise = keys.number("noise", {0, 1e6});
    keys.finish();
    o.sun = true;
    o.towardsSun = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                    std::sin(elevation)};
  }
  options.finish();
  if ((o.sun || o.interference > 0) && o.noise == 0) {
    throw InputError(options.where(), "effect detection: sun and interference need `noise`");
  }
  if (options.has("threshold") && o.noise == 0) {
    throw InputError(options.where(), "effect detection: a threshold, in units of the noise, needs `noise`");
  }
  return std::make_unique<Detection>(o, options.where());
}

}  // namespace scanmill
