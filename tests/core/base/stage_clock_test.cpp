#include "base/stage_clock.h"

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

// Takes at least this much processor time of the calling thread (s).
void work(double seconds) {
  const double begin = threadSeconds();
  while (threadSeconds() - begin < seconds) {
  }
}

TEST(StageClock, TimersAddProcessorTimeOrTimeOfTheClock) {
  StageClock clock;
  {
    const StageTimer waits(clock, "waits");
    const StageTimer walls(clock, "walls", StageTimer::Kind::Wall);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_TRUE(clock.seconds().empty()) << "nothing is added before the end";
  }
  EXPECT_GE(clock.seconds().at("walls"), 0.05);
  EXPECT_LT(clock.seconds().at("waits"), 0.02);
  for (int i = 0; i < 2; ++i) {
    const StageTimer timer(clock, "works");
    work(0.01);
  }
  EXPECT_GE(clock.seconds().at("works"), 0.02);
}

TEST(StageClock, ATimerCountsTheTasksThatOtherThreadsRunForIt) {
  StageClock clock;
  {
    const StageTimer outer(clock, "outer");
    const StageTimer inner(clock, "inner");
    parallelFor(8, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        parallelFor(2, 1, [](std::size_t a, std::size_t b) { work(0.005 * static_cast<double>(b - a)); });
      }
    });
  }
  EXPECT_GE(clock.seconds().at("inner"), 0.08);
  EXPECT_GE(clock.seconds().at("outer"), 0.08);
  EXPECT_LE(clock.seconds().at("inner"), processSeconds());
}

TEST(StageClock, ATaskForAnotherTimerIsNoPartOfTheThreadsOwn) {
  StageClock clock;
  {
    const StageTimer own(clock, "own");
    StageTimer* const mine = StageTimer::current();
    std::thread([&] {
      const StageTimer other(clock, "other");
      const StageTask task(mine);
      work(0.05);
    }).join();
  }
  EXPECT_GE(clock.seconds().at("own"), 0.05);
  EXPECT_LT(clock.seconds().at("other"), 0.02);
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
