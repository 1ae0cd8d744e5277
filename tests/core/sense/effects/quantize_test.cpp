#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

TEST(Quantize, RangesAreWholeStepsAtMostHalfAStepAway) {
  const World world = makeRaggedWorld(64, 512);
  for (double step : {0.002, 0.008, 0.05, 1.0}) {
    const Returns returns = run(world, {"quantize: {step_m: " + std::to_string(step) + "}"});
    for (std::size_t b = 0; b < world.hits.size(); ++b) {
      if (!world.hits.hit(b)) {
        EXPECT_EQ(returns.range[b], kMiss);
        continue;
      }
      const double steps = returns.range[b] / step;
      EXPECT_EQ(returns.range[b], static_cast<float>(std::round(steps) * step));
      EXPECT_LE(std::abs(returns.range[b] - static_cast<double>(world.hits.range[b])), step / 2 + 1e-5);
    }
  }
}

TEST(Quantize, AReturnStaysAReturn) {
  for (float range : {1e-6f, 1e-3f, 0.0039f, 0.0041f, 0.0119f}) {
    EXPECT_EQ(run(makeWorld(1, 1, range), {"quantize: {step_m: 0.008}"}).range[0], 0.008f) << range;
  }
  EXPECT_EQ(run(makeWorld(1, 1, 1e4f), {"quantize: {step_m: 0.008}"}).range[0], 1e4f);
}

}  // namespace
}  // namespace scanmill
