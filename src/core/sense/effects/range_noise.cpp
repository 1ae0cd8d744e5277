// range_noise: a Gaussian error of the range, along the beam.
//
//   range_noise: {sigma_m: 0.02, sigma_per_m: 0.0005}        # sigma(r) = 0.02 + 0.0005 r
//   range_noise: {table: [[1, 0.03], [20, 0.01], [100, 0.05]]}  # linear between the ranges, constant beyond them
//
//   range_noise: {sigma_m: 0.005, over_snr_m: 0.3}              # sigma^2 = 0.005^2 + (0.3 s / snr)^2
//
// over_snr_m makes the ranges of faint echoes noisy: snr is the signal to noise ratio that the effect `detection`
// computes. The error is that of a timing discriminator: the noise divided by the slope of the pulse (Skolnik,
// "Introduction to Radar Systems", 1981, section 11.3: the rise time over the signal to noise ratio). s is the length
// of the echo divided by the length of the pulse, sqrt(1 + (d / p)^2), where d is the spread of the footprint's ranges
// and p the standard deviation of the pulse, c t / 2 / 2.355: the noise therefore increases at grazing incidence.
//
// A noisy range is at least 1 mm (or the true range, if that is less), so that no point is behind the sensor. It may
// exceed the sensor's maximum range. If sigma is zero everywhere, no bit of the ranges changes.

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"
#include "sensors/footprint.h"

namespace scanmill {
namespace {

constexpr double kWidthOverSigma = 2.355;  // full width at half maximum of a Gaussian, in standard deviations

// A part of the table: from the range `start` (m) on, for `length` (m), sigma rises by `slope` per metre of range.
struct Ramp {
  double start, length, slope;
};

struct Sigma {
  double base = 0;    // m, standard deviation at range 0
  double growth = 0;  // growth of the standard deviation, m per m of range
  std::vector<Ramp> ramps;
  double overSnr = 0;  // m; part of the standard deviation that is divided by the SNR

  bool zero() const { return base == 0 && growth == 0 && ramps.empty() && overSnr == 0; }
};

// Reads the option `table`, a list of [range, sigma].
Sigma readSigmaTable(const Value& table) {
  const char* what = "effect range_noise: table";
  if (table.kind != Value::Kind::Sequence || table.items.empty()) {
    throw InputError(table.where, std::string(what) + " must be a list of [range, sigma] pairs in metres");
  }
  Sigma sigma;
  double lastRange = 0, lastSigma = 0;
  for (const Value& row : table.items) {
    const std::vector<double> pair = readNumbers(row, what, {0, 1e5});
    if (pair.size() != 2) throw InputError(row.where, std::string(what) + ": each row is [range, sigma] in metres");
    const double length = pair[0] - lastRange;
    if (&row == &table.items.front()) {
      sigma.base = pair[1];
    } else if (length <= 0) {
      throw InputError(row.where, std::string(what) + ": ranges must rise from row to row");
    } else if (pair[1] != lastSigma) {
      sigma.ramps.push_back({.start = lastRange, .length = length, .slope = (pair[1] - lastSigma) / length});
    }
    lastRange = pair[0];
    lastSigma = pair[1];
  }
  return sigma;
}

class RangeNoise : public Effect {
 public:
  explicit RangeNoise(Sigma sigma) : sigma_(std::move(sigma)) {}

  bool needsIntensity() const override { return sigma_.overSnr > 0; }
  bool needsSnr() const override { return sigma_.overSnr > 0; }

  void apply(const Hits&, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    change(shot, returns);
  }

 private:
  // Adds the noise to the ranges.
  SCANMILL_BEST_INSTRUCTIONS void change(const Shot& shot, Returns& returns) const {
    if (sigma_.zero()) return;
    RandomWords words;
    Batch<double> sigma;
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      float* const range = returns.range.data() + first;
      drawWords(shot, Purpose::RangeNoise, returns, first, words);
      for (std::size_t i = 0; i < count; ++i) sigma[i] = sigma_.base + sigma_.growth * range[i];
      for (const Ramp& ramp : sigma_.ramps) {
        for (std::size_t i = 0; i < count; ++i) {
          double along = range[i] - ramp.start;
          along = along > 0 ? along : 0;
          along = along < ramp.length ? along : ramp.length;
          sigma[i] += ramp.slope * along;
        }
      }
      if (sigma_.overSnr > 0) addNoiseOfFaintEchoes(shot, returns, first, count, sigma);
      for (std::size_t i = 0; i < count; ++i) {
        range[i] = rangeWithError(range[i], sigma[i] * normalPair(words.a[i], words.b[i]).first);
      }
    });
  }

  // Adds the noise of faint echoes (`over_snr_m`) to `sigma`, the standard deviations (m) of rows first, first + 1, ...
  void addNoiseOfFaintEchoes(const Shot& shot, const Returns& returns, std::size_t first, std::size_t count,
                             Batch<double>& sigma) const {
    if (returns.snr.size() != returns.size()) {
      throw InputError("effect range_noise: over_snr_m needs the effect `detection` with the key `noise`");
    }
    const double pulseSigma = pulseLength(shot.beams->pulse) / kWidthOverSigma;  // m
    for (std::size_t i = 0; i < count; ++i) {
      const double spread = returns.spread.empty() ? 0 : returns.spread[first + i] / pulseSigma;
      const double snr = returns.snr[first + i] > 1e-3 ? returns.snr[first + i] : 1e-3;
      const double sigmaOfSnr = sigma_.overSnr / snr;
      sigma[i] = std::sqrt(sigma[i] * sigma[i] + sigmaOfSnr * sigmaOfSnr * (1 + spread * spread));
    }
  }

  Sigma sigma_;
};

}  // namespace

std::unique_ptr<Effect> makeRangeNoise(Fields& options) {
  Sigma sigma;
  const bool constant = options.has("sigma_m") || options.has("sigma_per_m");
  if (const Value* table = options.find("table")) {
    if (constant) {
      throw InputError(
          table->where,
          "effect range_noise: give either a table or sigma_m and sigma_per_m (beside `sensor`, `table: null` "
          "leaves out the sensor's own table)");
    }
    sigma = readSigmaTable(*table);
  }
  sigma.base += options.number("sigma_m", {0, 100}, 0);
  sigma.growth = options.number("sigma_per_m", {0, 1}, 0);
  sigma.overSnr = options.number("over_snr_m", {0, 100}, 0);
  options.finish();  // reports unknown keys first, since an unknown key may be a misspelt required key
  if (!constant && !options.has("table") && !options.has("over_snr_m")) {
    throw InputError(options.where(), "effect range_noise: give sigma_m, sigma_per_m, over_snr_m or a table");
  }
  return std::make_unique<RangeNoise>(std::move(sigma));
}

}  // namespace scanmill
