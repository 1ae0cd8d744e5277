#include <set>

#include "base/random.h"
#include "study/tradeoff/study.h"
#include "tests/studio/study/tradeoff/example_study.h"

namespace scanmill {
namespace {

// From the exact one: 4 % faster is none, 6 % is one, and what is 4 % faster than that is none again.
TEST(StudyFigures, AFrontHasNoStepsWithinTheNoiseOfTime) {
  Study study = studyOf({});
  double milliseconds = 100, p99 = 0.01, labels = 1;
  for (const double step : {1.0, 1.04, 1.02, 1.04, 1.5}) {
    const std::string name = study.settings.empty() ? "" : "simplify=0." + std::to_string(study.settings.size());
    study.settings.push_back(exampleResult({"ray_tracing", name, milliseconds /= step, p99 *= 1.5, labels -= 0.01, 0}));
  }
  EXPECT_THAT(frontOf(study, rangeP99), testing::ElementsAre(4, 2, 0));
  EXPECT_THAT(frontOf(study, wrongShare), testing::ElementsAre(4, 2, 0));
}

TEST(StudyFigures, AFrontIsWhatBruteForceFinds) {
  for (std::uint32_t stream = 0; stream < 50; ++stream) {
    std::vector<ExampleSetting> settings;
    for (std::uint32_t i = 0; i < 60; ++i) {
      const RandomBlock r = randomBlock({11, stream, 0, 0, i, 0, Purpose::Test});
      // Few values, so that there are equals; steps of time that are larger than noise.
      settings.push_back({"particle", "voxels=" + std::to_string(i), std::pow(1.1, r[0] % 9), 0.01 * (r[1] % 9), 1, 0});
      if (r[2] % 20 == 0) settings.back().p99 = std::nan("");
    }
    const Study study = studyOf(settings);
    using Point = std::pair<double, double>;
    std::set<Point> expected;
    for (const ExampleSetting& a : settings) {
      const bool beaten = std::ranges::any_of(settings, [&](const ExampleSetting& b) {
        return b.milliseconds <= a.milliseconds && b.p99 <= a.p99 && (b.milliseconds < a.milliseconds || b.p99 < a.p99);
      });
      if (!beaten && !std::isnan(a.p99)) expected.insert({a.milliseconds, a.p99});
    }
    std::vector<Point> front;
    for (const std::size_t i : frontOf(study, rangeP99)) front.push_back({settings[i].milliseconds, settings[i].p99});
    EXPECT_EQ(front, std::vector<Point>(expected.begin(), expected.end())) << stream;
  }
  EXPECT_TRUE(frontOf(Study{}, rangeP99).empty());
}

}  // namespace
}  // namespace scanmill
