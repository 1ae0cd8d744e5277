// ring_bias: the errors of each laser's range, elevation and gain that remain after the calibration of a sensor. A ring
// has the same errors in all its beams and in all frames of a dataset.
//
//   ring_bias: {range_sigma_m: 0.02, elevation_sigma_deg: 0.02, gain_sigma: 0.2}
//   ring_bias: {range_m: [0.01, -0.02, ...], elevation_deg: [...], gain: [...]}   # one value per ring
//
// Errors of range and elevation are the reported minus the true value, elevation positive upwards; the gain is a factor
// on the power. The keys with `sigma` are standard deviations of Gaussian numbers, sampled once per sensor and ring
// from the pipeline's seed; the gain is then exp(gain_sigma * number). Each of the three errors is given either by its
// sigma or as a list. A reported range is at least 1 mm, or the range before this effect if that is less.

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

// One kind of error: either a list with a value per ring, or the standard deviation for sampling values.
struct PerRing {
  double sigma = 0;          // standard deviation; used if `list` is empty
  std::vector<double> list;  // error of each ring
  Location where;            // location of the list

  bool zero() const { return sigma == 0 && list.empty(); }
  // Returns the error of a ring. `normal`: a standard normal random number.
  double errorOf(std::uint32_t ring, double normal) const { return list.empty() ? sigma * normal : list[ring]; }
};

class RingBias : public Effect {
 public:
  RingBias(PerRing range, PerRing elevation, PerRing gain)
      : range_(std::move(range)), elevation_(std::move(elevation)), gain_(std::move(gain)) {}

  bool setsGain() const override { return !gain_.zero(); }

  void check(const BeamTable& beams) const override {
    for (const PerRing* errors : {&range_, &elevation_, &gain_}) {
      if (errors->list.empty() || errors->list.size() == beams.rings) continue;
      throw InputError(errors->where, "effect ring_bias: the number of values is " +
                                          std::to_string(errors->list.size()) + ", but the number of rings is " +
                                          std::to_string(beams.rings) + ": give one value per ring");
    }
  }

  void apply(const Hits&, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    check(*shot.beams);
    if (!gain_.zero()) returns.gain.resize(returns.size(), 1.0f);
    if (!elevation_.zero()) returns.displacement.resize(returns.size());
    const std::uint32_t columns = shot.beams->columns;
    std::vector<Errors> errors;
    for (std::uint32_t ring = 0; ring < shot.beams->rings; ++ring) errors.push_back(errorsOf(shot, ring));
    for (std::size_t row = 0; row < returns.size();) {
      const std::uint32_t ring = returns.beam(row) / columns;
      const std::uint32_t firstBeam = ring * columns;
      std::size_t end = returns.onePerBeam() ? row + columns : row + 1;  // end of consecutive rows of the same ring
      while (end < returns.size() && returns.beam(end) - firstBeam < columns) ++end;
      change(errors[ring], shot, row, end - row, returns);
      row = end;
    }
  }

 private:
  // The errors of one ring.
  struct Errors {
    double range = 0;  // m, added to the range
    SinCos elevation{0, 1};
    double gain = 1;  // factor on the power
  };

  Errors errorsOf(const Shot& shot, std::uint32_t ring) const {
    const RandomBlock words =
        randomBlock({.seed = shot.seed, .sensor = shot.sensor, .beam = ring, .purpose = Purpose::RingBias});
    const NormalPair first = normalPair(words[0], words[1]);
    const NormalPair second = normalPair(words[2], words[3]);
    Errors errors;
    errors.range = range_.errorOf(ring, first.first);
    errors.elevation = sinCosSmall(radians(elevation_.errorOf(ring, first.second)));
    if (!gain_.zero()) errors.gain = gain_.list.empty() ? exponential(gain_.sigma * second.first) : gain_.list[ring];
    return errors;
  }

  // Applies the errors of one ring to consecutive rows of the ring.
  SCANMILL_BEST_INSTRUCTIONS void change(const Errors& errors, const Shot& shot, std::size_t firstRow,
                                         std::size_t count, Returns& returns) const {
    float* const range = returns.range.data() + firstRow;
    for (std::size_t i = 0; i < count && !elevation_.zero(); ++i) {
      const Vec3d& d = shot.beams->direction[returns.beam(firstRow + i)];
      const double horizontal = std::sqrt(d.x * d.x + d.y * d.y);
      const double tilted = horizontal * errors.elevation.cos - d.z * errors.elevation.sin;
      const double growth = horizontal > 0 ? tilted / horizontal - 1 : 0.0;
      const double scale = range[i] < kMiss ? range[i] : 0.0;
      Vec3f& displacement = returns.displacement[firstRow + i];
      displacement.x += static_cast<float>(scale * d.x * growth);
      displacement.y += static_cast<float>(scale * d.y * growth);
      displacement.z +=
          static_cast<float>(scale * (d.z * errors.elevation.cos + horizontal * errors.elevation.sin - d.z));
    }
    for (std::size_t i = 0; i < count && !range_.zero(); ++i) range[i] = rangeWithError(range[i], errors.range);
    for (std::size_t i = 0; i < count && !gain_.zero(); ++i) {
      returns.gain[firstRow + i] *= static_cast<float>(errors.gain);
    }
  }

  PerRing range_;      // errors of the range (m)
  PerRing elevation_;  // errors of the elevation (deg)
  PerRing gain_;
};

// Reads one kind of error: its standard deviation from `sigmaKey`, or its values from `listKey`; else no error.
PerRing readPerRing(Fields& options, const char* sigmaKey, Range sigmaLimits, const char* listKey, Range valueLimits) {
  PerRing errors;
  if (const Value* list = options.find(listKey)) {
    if (options.has(sigmaKey)) {
      throw InputError(list->where, std::string("effect ring_bias: give either ") + listKey + " or " + sigmaKey);
    }
    errors.list = readNumbers(*list, std::string("effect ring_bias: ") + listKey, valueLimits);
    errors.where = list->where;
  }
  errors.sigma = options.number(sigmaKey, sigmaLimits, 0);
  return errors;
}

}  // namespace

std::unique_ptr<Effect> makeRingBias(Fields& options) {
  PerRing range = readPerRing(options, "range_sigma_m", {0, 1}, "range_m", {-10, 10});
  PerRing elevation = readPerRing(options, "elevation_sigma_deg", {0, 2}, "elevation_deg", {-10, 10});
  PerRing gain = readPerRing(options, "gain_sigma", {0, 3}, "gain", {0, 1000});
  options.finish();  // reports unknown keys first, since an unknown key may be a misspelt required key
  constexpr const char* kKeys[] = {"range_sigma_m", "elevation_sigma_deg", "gain_sigma",
                                   "range_m",       "elevation_deg",       "gain"};
  if (std::ranges::none_of(kKeys, [&](const char* key) { return options.has(key); }))
    throw InputError(options.where(), "effect ring_bias: give a spread or a list of range, elevation or gain");
  return std::make_unique<RingBias>(std::move(range), std::move(elevation), std::move(gain));
}

}  // namespace scanmill
