#include "base/stage_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "base/parallel.h"

namespace scanmill {
namespace {

using testing::ElementsAre;
using testing::Pair;

TEST(StageClock, AddsUpByStage) {
  StageClock clock;
  EXPECT_TRUE(clock.seconds().empty());
  clock.add("march", 0.5);
  clock.add("launch", 1);
  clock.add("march", 0.25);
  EXPECT_THAT(clock.seconds(), ElementsAre(Pair("launch", 1), Pair("march", 0.75)));
  StageSeconds all{{"march", 1}, {"read", 2}};
  addSeconds(clock.seconds(), all);
  EXPECT_THAT(all, ElementsAre(Pair("launch", 1), Pair("march", 1.75), Pair("read", 2)));
}

TEST(StageClock, NamedStagesAreToldWithoutAnySecond) {
  StageClock clock({"render", "sample"});
  clock.add("sample", 3);
  EXPECT_THAT(clock.seconds(), ElementsAre(Pair("render", 0), Pair("sample", 3)));
}

TEST(StageClock, TimersAddTheirLifetimes) {
  StageClock clock;
  for (int i = 0; i < 2; ++i) {
    const StageTimer timer(clock, "sleep");
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(clock.seconds().count("sleep"), i) << "nothing is added before the end";
  }
  EXPECT_GE(clock.seconds().at("sleep"), 0.01);
}

TEST(StageClock, ThreadsAddAtOnce) {
  StageClock clock;
  parallelFor(1000, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) clock.add(i % 2 == 0 ? "even" : "odd", 0.5);
  });
  EXPECT_THAT(clock.seconds(), ElementsAre(Pair("even", 250), Pair("odd", 250)));
}

}  // namespace
}  // namespace scanmill
