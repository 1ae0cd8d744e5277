#include "tests/studio/study/tradeoff/example_study.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using testing::Not;

// The advice whose need holds these words.
Advice adviceFor(const Study& study, const std::string& need) {
  for (const Advice& a : advise(study)) {
    if (a.need.find(need) != std::string::npos) return a;
  }
  return {"nothing for " + need, "none", ""};
}

TEST(Advice, EachNeedTakesTheFastestThatHolds) {
  const Study study = studyOf({{"ray_tracing", "", 10, 0, 1, 0},
                               {"depth_camera", "", 5, 0.015, 0.997, 1e-3},
                               {"depth_camera", "resolution=512", 3, 0.2, 0.96, 5e-3},
                               {"particle", "refine=none", 1, 3, 0.7, 0.02}});
  EXPECT_EQ(adviceFor(study, "exact ranges and labels").setting, "ray_tracing");
  EXPECT_EQ(adviceFor(study, "centimetres").setting, "depth_camera");
  EXPECT_EQ(adviceFor(study, "a decimetre for 95 % of the beams").setting, "depth_camera resolution=512");
  EXPECT_EQ(adviceFor(study, "speed at any price").setting, "particle refine=none");
  const std::string camera = adviceFor(study, "centimetres").text;
  EXPECT_THAT(camera, HasSubstr("26.2 M beams a second, 2.0 x as fast as ray tracing with defaults"));
  EXPECT_THAT(camera, HasSubstr("99 % of the ranges within 15 mm; 99.70 % of the labels agree; 0.100 % of the beams"));
}

// A method that cannot fire several rays a beam is no advice for a pipeline that asks for them, without a word.
TEST(Advice, SaysWhatThePipelineRefuses) {
  Study study = studyOf({{"ray_tracing", "", 10, 0, 1, 0}, {"depth_camera", "", 5, 0.015, 0.997, 1e-3}});
  EXPECT_THAT(adviceFor(study, "centimetres").text, Not(HasSubstr("cannot use")));
  study.refused = {"depth_camera"};
  EXPECT_THAT(adviceFor(study, "centimetres").text, HasSubstr("The pipeline cannot use depth_camera"));
  EXPECT_THAT(adviceFor(study, "exact").text, Not(HasSubstr("cannot use")));
}

TEST(Advice, WithinTheNoiseOfTimeDefaultsAreTaken) {
  for (const auto& [milliseconds, taken] : {std::pair(9.8, "ray_tracing"), {9.0, "ray_tracing instancing=never"}}) {
    const Study study =
        studyOf({{"ray_tracing", "", 10, 0, 1, 0}, {"ray_tracing", "instancing=never", milliseconds, 0, 1, 0}});
    EXPECT_EQ(adviceFor(study, "exact").setting, taken);
  }
}

TEST(Advice, OfEquallyFastSettingsTheMostExactIsTaken) {
  const auto fastest = [](double labels, double p99) {
    return adviceFor(studyOf({{"ray_tracing", "", 20, 0, 1, 0},
                              {"ray_tracing", "simplify=0.2", 10, 0.6, 0.95, 4e-3},
                              {"ray_tracing", "simplify=0.5", 10.9, p99, labels, 4e-3}}),
                     "speed at any price")
        .setting;
  };
  EXPECT_EQ(fastest(0.97, 0.7), "ray_tracing simplify=0.5") << "fewer wrong beams come first";
  EXPECT_EQ(fastest(0.95, 0.5), "ray_tracing simplify=0.5") << "then the ranges";
  EXPECT_EQ(fastest(0.95, 0.7), "ray_tracing simplify=0.2");
  EXPECT_EQ(fastest(0.90, 0.5), "ray_tracing simplify=0.2");
}

// The largest factors are worked out by hand.
TEST(Advice, WhereNoneHoldsTheNearestIsNamed) {
  const auto nearest = [](const std::vector<ExampleSetting>& settings) {
    const Advice exact = adviceFor(studyOf(settings), "centimetres");
    EXPECT_EQ(exact.setting, "");
    EXPECT_THAT(exact.text, HasSubstr("No setting that was measured keeps 99 % of the ranges within 2 cm"));
    return exact.text;
  };
  EXPECT_THAT(nearest({{"depth_camera", "", 5, 0.03, 0.996, 1e-3}, {"particle", "", 4, 2, 0.8, 0.01}}),
              HasSubstr("The nearest is depth_camera: "));
  EXPECT_THAT(nearest({{"ray_tracing", "three=p99", 5, 0.06, 1, 0},
                       {"ray_tracing", "fivefold=misses", 5, 0, 1, 0.01},
                       {"ray_tracing", "twofold=labels", 5, 0.02, 0.99, 0.002},
                       {"ray_tracing", "both=2.1,2.4", 5, 0.042, 1, 0.0048}}),
              HasSubstr("The nearest is ray_tracing twofold=labels: "));
}

TEST(Advice, EmptyFailedAndBlindStudies) {
  EXPECT_TRUE(advise(Study{}).empty());
  Study failed = studyOf({{"depth_camera", "renderer=blender", 1, 0, 1, 0}, {"ray_tracing", "", 5, 0, 1, 0}});
  failed.settings[0].failure = "no Blender";
  failed.settings[0].measured = {};
  EXPECT_EQ(adviceFor(failed, "exact").setting, "ray_tracing") << "failures do not shift the others";
  failed.settings.pop_back();
  EXPECT_TRUE(advise(failed).empty());
  const Study blind = studyOf({{"depth_camera", "", 5, std::nan(""), 1, 0}});
  EXPECT_THAT(adviceFor(blind, "exact").text, HasSubstr("No setting that was measured"));
  EXPECT_THAT(adviceFor(blind, "exact").text, Not(HasSubstr("ray tracing"))) << "it was not measured";
}

}  // namespace
}  // namespace scanmill
