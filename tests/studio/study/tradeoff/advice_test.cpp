#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  EXPECT_THAT(camera, HasSubstr("2.0 x as fast as ray tracing with defaults"));
  EXPECT_THAT(camera, HasSubstr("lie within 1.88 mm, 99 % within 15 mm (there: exact)"));
  EXPECT_THAT(camera, HasSubstr("99.70 % of the labels agree (there: 100 %)"));
  EXPECT_THAT(camera, HasSubstr("26.2 M beams a second"));
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
  for (const auto& [milliseconds, taken] : {std::pair(9.8, "ray_tracing"), {9.0, "ray_tracing bvh=low"}}) {
    const Study study = studyOf({{"ray_tracing", "", 10, 0, 1, 0}, {"ray_tracing", "bvh=low", milliseconds, 0, 1, 0}});
    EXPECT_EQ(adviceFor(study, "every").setting, taken);
  }
}

// The fastest is within the noise of the exact one's time: nothing is to be had for its error.
TEST(Advice, WhatIsNotNotablyFasterIsNoTrade) {
  const std::vector<Advice> advice = advise(studyOf({{"ray_tracing", "", 10.8, 0, 1, 0},
                                                     {"ray_tracing", "simplify=0.25", 10.3, 0.9, 0.97, 5e-3},
                                                     {"ray_tracing", "simplify=0.1", 10, 0.6, 0.95, 4e-3}}));
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_EQ(advice[0].need, "For every need");
  EXPECT_EQ(advice[0].setting, "ray_tracing");
  EXPECT_THAT(advice[0].text, HasSubstr("none is more exact"));
  EXPECT_THAT(advice[0].text,
              HasSubstr("none is notably faster. The fastest, ray_tracing simplify=0.1, is 8 % faster"));
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

// 5.4 ms are 10.2 % more than 4.9 ms, but no more than 5.2 ms.
TEST(Advice, ASettingThatIsAsFastAndExactAsDefaultsIsNotAdvised) {
  const Study study = studyOf({{"ray_tracing", "", 5.4, 0, 1, 0},
                               {"ray_tracing", "bvh=high", 5.2, 0, 1, 0},
                               {"ray_tracing", "robust=false", 4.9, 0, 0.9999, 0},
                               {"ray_tracing", "simplify=0.1", 2, 1, 0.9, 0.05}});
  EXPECT_EQ(adviceFor(study, "exact ranges and labels").setting, "ray_tracing");
}

TEST(Advice, HeadingsReadAsSentences) {
  const Study study = studyOf(
      {{"ray_tracing", "", 10, 0, 1, 0}, {"depth_camera", "", 5, 0.2, 0.96, 5e-3}, {"particle", "", 30, 0, 1, 0}});
  const std::vector<Advice> advice = advise(study);
  ASSERT_EQ(advice.size(), 3u);
  EXPECT_EQ(advice[0].need, "For exact ranges and labels, and for centimetres");
  EXPECT_EQ(advice[1].need, "For a decimetre for 95 % of the beams, and for speed at any price");
  EXPECT_EQ(advice[2].need, "Whether to take particle");
  for (const Advice& a : advice) EXPECT_THAT(a.text, Not(HasSubstr("  ")));
}

TEST(Advice, OneWinnerOfAllNeedsIsSaidOnce) {
  Study study = studyOf({{"ray_tracing", "", 5, 0, 1, 0},
                         {"depth_camera", "", 10.5, 0.04, 0.98, 1e-3},
                         {"depth_camera", "resolution=512", 8, 0.2, 0.95, 2e-3},
                         {"particle", "", 20, 0, 1, 0}});
  const std::vector<Advice> advice = advise(study);
  ASSERT_EQ(advice.size(), 3u);
  EXPECT_EQ(advice[0].need, "For every need");
  EXPECT_EQ(advice[0].setting, "ray_tracing");
  EXPECT_THAT(advice[0].text, HasSubstr("It suits every need: of 4 settings it is the fastest"));
  EXPECT_THAT(advice[1].text, HasSubstr("depth_camera is 2.1 x slower than ray tracing with defaults and less exact"));
  EXPECT_THAT(advice[1].text, HasSubstr("p99 of the ranges 40 mm against exact"));
  EXPECT_THAT(advice[1].text, HasSubstr("no reason to take it here"));
  EXPECT_THAT(advice[1].text, HasSubstr("each of its 2 settings"));
  EXPECT_THAT(advice[1].text, HasSubstr(". OpenGL ran on"));
  EXPECT_THAT(advice[2].text, HasSubstr("particle is 4.0 x slower than ray tracing with defaults and no more exact"));
  for (const Advice& a : {advice[1], advice[2]}) EXPECT_EQ(a.setting, "");
  study.machine.renderer = "NVIDIA H200/PCIe/SSE2";
  EXPECT_THAT(adviceFor(study, "depth_camera").text, Not(HasSubstr("OpenGL ran on"))) << "a card needs no remark";
}

TEST(Advice, DominatedSettingsAreCalledSo) {
  const Study study = studyOf({{"ray_tracing", "", 5, 0, 1, 0},
                               {"ray_tracing", "packet=1", 15, 0, 1, 0},
                               {"ray_tracing", "simplify=0.5", 5.1, 0.02, 0.99, 1e-3},
                               {"ray_tracing", "bvh=high", 5.1, 0, 1, 0}});
  const Advice not_ = adviceFor(study, "What not to take");
  EXPECT_THAT(not_.text, HasSubstr("ray_tracing packet=1 (3.0 x slower than ray_tracing, no more exact)"));
  for (const char* asFast : {"simplify=0.5", "bvh=high"}) {
    EXPECT_THAT(not_.text, Not(HasSubstr(asFast))) << "two measurements of one speed differ by as much";
  }
}

TEST(Advice, WhereNoneHoldsTheNearestIsNamedWithWhatBreaks) {
  const Study study = studyOf({{"depth_camera", "", 5, 0.03, 0.996, 1e-3}, {"particle", "", 4, 2, 0.8, 0.01}});
  const Advice exact = adviceFor(study, "exact ranges and labels");
  EXPECT_EQ(exact.setting, "");
  EXPECT_THAT(exact.text, HasSubstr("No setting that was measured keeps"));
  EXPECT_THAT(exact.text, HasSubstr("The nearest is depth_camera: "));
  EXPECT_THAT(exact.text, HasSubstr("30 mm"));
  EXPECT_EQ(adviceFor(study, "speed at any price").setting, "particle");
}

TEST(Advice, AMethodThatIsUndominatedIsNotCondemned) {
  // Slower than the fastest and less exact than the exact one, but nothing beats it in both.
  const Study study = studyOf({{"ray_tracing", "", 10, 0, 1, 0},
                               {"depth_camera", "", 8, 0.03, 0.99, 1e-3},
                               {"particle", "", 1, 3, 0.99, 1e-3},
                               {"particle", "voxels=128", 7, 0.09, 0.99, 1e-3}});
  const Advice camera = adviceFor(study, "depth_camera");
  EXPECT_THAT(camera.text, HasSubstr("no setting is better than depth_camera in everything"));
  EXPECT_THAT(camera.text, Not(HasSubstr("no reason to take it")));
}

TEST(Advice, EmptyFailedAndSingleStudies) {
  EXPECT_TRUE(advise(Study{}).empty());
  Study failed = studyOf({{"depth_camera", "renderer=blender", 1, 0, 1, 0}, {"ray_tracing", "", 5, 0, 1, 0}});
  failed.settings[0].failure = "no Blender";
  failed.settings[0].measured = {};
  EXPECT_EQ(adviceFor(failed, "every need").setting, "ray_tracing") << "failures do not shift the others";
  failed.settings.pop_back();
  EXPECT_TRUE(advise(failed).empty());
  const std::vector<Advice> one = advise(studyOf({{"ray_tracing", "", 5, 0, 1, 0}}));
  ASSERT_EQ(one.size(), 1u);
  EXPECT_THAT(one[0].text, HasSubstr("Only this setting was measured"));
  EXPECT_EQ(one[0].setting, "ray_tracing");
}

TEST(Advice, WithoutRayTracingNothingIsComparedWithIt) {
  for (const Advice& a : advise(studyOf({{"depth_camera", "", 5, 0, 1, 0}, {"particle", "", 9, 0.1, 0.9, 0.01}}))) {
    EXPECT_THAT(a.text, Not(HasSubstr("ray tracing")));
  }
}

}  // namespace
}  // namespace scanmill
