// quantize: the sensor reports ranges as multiples of a step.
//
//   quantize: {step_m: 0.008}
//
// No return is lost: ranges below half a step are reported as one step.

#include <cmath>

#include "base/instruction_sets.h"
#include "sense/effects/makers.h"

namespace scanmill {
namespace {

class Quantize : public Effect {
 public:
  explicit Quantize(double step) : step_(step) {}

  void apply(const Hits&, const Shot&, std::span<const Material>, Returns& returns) const override { change(returns); }

 private:
  SCANMILL_BEST_INSTRUCTIONS void change(Returns& returns) const {
    const double stepsPerMetre = 1 / step_;
    for (float& range : returns.range) {
      const double steps = std::floor(range * stepsPerMetre + 0.5);
      range = static_cast<float>((steps > 1 ? steps : 1.0) * step_);
    }
  }

  double step_;  // m, ranges are rounded to multiples of this
};

}  // namespace

std::unique_ptr<Effect> makeQuantize(Fields& options) {
  options.also({"step_m"}).finish();
  const double step = options.number("step_m", {1e-6, 10});
  options.finish();
  return std::make_unique<Quantize>(step);
}

}  // namespace scanmill
