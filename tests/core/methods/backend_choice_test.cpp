#include "methods/backend_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"

namespace scanmill {
namespace {

using Asked = BackendChoice::Asked;

// Work that takes so long and finds a surface at a range (m), or fails after so many shots; counts how often it is
// done.
struct Way {
  int milliseconds = 0;
  float range = 5;
  int fails = 1000;
  int done = 0;

  BackendChoice::Way work() {
    return [this](Hits& hits, StageClock& clock) {
      if (++done > fails) throw Error("out of memory");
      clock.add("worked", 1);
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      hits.range = {range};
    };
  }
};

// Whether the device takes a shot.
bool takesDevice(BackendChoice& choice, Way& device, Way& processor) {
  StageClock clock;
  Hits hits;
  const int before = device.done;
  choice.trace(BackendChoice::kFewRays, device.work(), processor.work(), hits, clock);
  EXPECT_EQ(hits.range.size(), 1u);
  EXPECT_EQ(clock.seconds().at("worked"), 1) << "tries do not count";
  return device.done > before && hits.range == std::vector{device.range};
}

TEST(BackendChoice, TakesWhatIsAskedForWithoutTrying) {
  for (const auto& [asked, there, expected] :
       {std::tuple(Asked::Cpu, false, false), {Asked::Gl, true, true}, {Asked::Auto, false, false}}) {
    BackendChoice choice(asked, there ? "a card" : "", "tests run");
    Way device{.range = 6};
    Way processor;
    EXPECT_EQ(takesDevice(choice, device, processor), expected);
    EXPECT_EQ(device.done + processor.done, 1);
  }
}

TEST(BackendChoice, AutoTakesTheFasterOneForGood) {
  for (const bool faster : {false, true}) {
    BackendChoice choice(Asked::Auto, "a card", "tests run");
    Way device{.milliseconds = faster ? 1 : 60};
    Way processor{.milliseconds = faster ? 60 : 1};
    for (int shot = 1; shot < 4; ++shot) {
      takesDevice(choice, device, processor);
      EXPECT_EQ(device.done, 2 + (faster ? shot : 0));
      EXPECT_EQ(processor.done, 2 + (faster ? 0 : shot));
    }
  }
}

// They would choose by what it takes to ask the device.
TEST(BackendChoice, FewRaysAreTheProcessors) {
  for (const Asked asked : {Asked::Auto, Asked::Gl}) {
    BackendChoice choice(asked, "a card", "tests run");
    Way device;
    Way processor;
    StageClock clock;
    Hits hits;
    choice.trace(BackendChoice::kFewRays - 1, device.work(), processor.work(), hits, clock);
    EXPECT_EQ(device.done, 0);
    EXPECT_EQ(processor.done, 1);
    EXPECT_EQ(choice.outcome(), asked == Asked::Gl ? "a card" : "");
  }
}

TEST(BackendChoice, TellsWhoTakesTheShots) {
  for (const bool faster : {false, true}) {
    BackendChoice choice(Asked::Auto, "a card", "tests run");
    Way device{.milliseconds = faster ? 1 : 60};
    Way processor{.milliseconds = faster ? 60 : 1};
    takesDevice(choice, device, processor);
    EXPECT_THAT(choice.outcome(),
                testing::MatchesRegex(faster ? "a card \\([0-9.]+ ms a scan; the processor [0-9.]+ ms\\)"
                                             : "the processor \\([0-9.]+ ms a scan; a card [0-9.]+ ms\\)"));
  }
  BackendChoice failing(Asked::Auto, "a card", "tests run, told");
  Way device{.fails = 0};
  Way processor;
  takesDevice(failing, device, processor);
  EXPECT_EQ(failing.outcome(), "the processor, since a card had failed");
}

TEST(BackendChoice, ADeviceThatFindsOtherHitsIsNotTaken) {
  BackendChoice choice(Asked::Auto, "a card", "tests run");
  Way device{.range = 5.0000005f};
  Way processor{.milliseconds = 30};
  const std::size_t before = warningCount();
  EXPECT_FALSE(takesDevice(choice, device, processor));
  EXPECT_EQ(warningCount(), before + 1);
}

// At once, or in the midst of a run.
TEST(BackendChoice, TheProcessorTakesOverFromADeviceThatFails) {
  for (const int fails : {0, 2, 5}) {
    BackendChoice choice(Asked::Auto, "a card", "tests run after " + std::to_string(fails));
    Way device{.fails = fails};
    Way processor{.milliseconds = 20};
    const std::size_t before = warningCount();
    for (int shot = 0; shot < 6; ++shot) takesDevice(choice, device, processor);
    EXPECT_EQ(device.done, fails + 1) << "it is not asked again";
    EXPECT_EQ(warningCount(), before + 1);
  }
  BackendChoice asked(Asked::Gl, "a card", "tests run");
  Way device{.fails = 0};
  Way processor;
  EXPECT_THROW(takesDevice(asked, device, processor), Error);
  EXPECT_EQ(processor.done, 0);
}

}  // namespace
}  // namespace scanmill
