// range_walk: strong returns are measured too near.
//
//   range_walk: {per_decade_m: 0.02, above: 1}
//
// The stronger a pulse is, the earlier it exceeds the receiver's threshold. If the power P of a return exceeds `above`,
// the range is reduced by per_decade_m log10(P / above), but not below the sensor's minimum range. Sensors correct most
// of this error, and manufacturers do not publish the remaining error.

#include "sense/effects/elementary.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

class RangeWalk : public Effect {
 public:
  RangeWalk(double perDecade, double above) : perDecade_(perDecade), above_(above) {}

  bool needsIntensity() const override { return true; }

  void apply(const Hits&, const Shot& shot, std::span<const Material>, Returns& returns) const override {
    constexpr double kPerDecade = 0.43429448190325182765;  // 1 / log(10)
    for (std::size_t row = 0; row < returns.size(); ++row) {
      const double power = returns.power[row];
      if (!returns.returned(row) || power <= above_) continue;
      const double range = returns.range[row];
      const double nearer = range - perDecade_ * kPerDecade * naturalLog(power / above_);
      returns.range[row] = static_cast<float>(std::max(nearer, std::min(range, shot.beams->minRange)));
    }
  }

 private:
  double perDecade_, above_;
};

}  // namespace

std::unique_ptr<Effect> makeRangeWalk(Fields& options) {
  options.also({"per_decade_m", "above"}).finish();
  const double perDecade = options.number("per_decade_m", {0, 10});
  const double above = options.number("above", {1e-6, 1e6}, 1);
  options.finish();
  return std::make_unique<RangeWalk>(perDecade, above);
}

}  // namespace scanmill
