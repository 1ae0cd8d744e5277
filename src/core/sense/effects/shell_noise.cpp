// shell: adds a random unit vector times a scale to each point. Each point is moved to a sphere around the true point,
// and therefore off its beam. No sensor has this error, but published datasets do; the effect serves comparisons.
//
//   shell: {scale_m: 0.0, growth_per_m: 0.01}     # scale(r) = scale_m + growth_per_m * r, with the range r in m
//
// The scale is at most half the range, so that no point is behind the sensor.

#include "base/instruction_sets.h"
#include "sense/effects/batches.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

class ShellNoise : public Effect {
 public:
  ShellNoise(double scale, double growth) : scale_(scale), growth_(growth) {}

  void apply(const Hits&, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    change(shot, returns);
  }

 private:
  SCANMILL_BEST_INSTRUCTIONS void change(const Shot& shot, Returns& returns) const {
    if (scale_ == 0 && growth_ == 0) return;
    returns.displacement.resize(returns.range.size());
    RandomWords words;
    forBatches(returns.range, [&](std::size_t first, std::size_t count) {
      const float* const range = returns.range.data() + first;
      Vec3f* const displacement = returns.displacement.data() + first;
      drawWords(shot, Purpose::ShellNoise, returns, first, words);
      for (std::size_t i = 0; i < count; ++i) {
        const double r = range[i] < kMiss ? range[i] : 0.0;
        const double unlimitedScale = scale_ + growth_ * r;
        const double scale = unlimitedScale < 0.5 * r ? unlimitedScale : 0.5 * r;
        // Zones of a sphere with equal heights have equal areas (Archimedes), so z is uniformly distributed.
        const double z = (toDouble(words.a[i]) + 0.5) * 0x1p-31 - 1;
        const double horizontal = std::sqrt(1 - z * z);
        const SinCos angle = sinCosRandom(words.b[i]);
        displacement[i].x += static_cast<float>(scale * horizontal * angle.cos);
        displacement[i].y += static_cast<float>(scale * horizontal * angle.sin);
        displacement[i].z += static_cast<float>(scale * z);
      }
    });
  }

  double scale_;   // m, displacement at range 0
  double growth_;  // increase of the displacement with the range (m/m)
};

}  // namespace

std::unique_ptr<Effect> makeShellNoise(Fields& options) {
  const double scale = options.number("scale_m", {0, 100}, 0);
  const double growth = options.number("growth_per_m", {0, 0.5}, 0);
  options.finish();  // reports unknown keys first, since an unknown key may be a misspelt required key
  if (!options.has("scale_m") && !options.has("growth_per_m")) {
    throw InputError(options.where(), "effect shell: give scale_m, growth_per_m or both");
  }
  return std::make_unique<ShellNoise>(scale, growth);
}

}  // namespace scanmill
