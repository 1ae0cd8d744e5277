#include "study/tradeoff/study_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace scanmill
