#include "viewer/window/playback.h"

#include "tests/studio/viewer/window/fake_frames.h"

namespace scanmill {
namespace {

struct Player {
  explicit Player(std::size_t count, const std::string& sample = "#0") : frames(std::make_shared<FakeFrames>(count)) {
    playback.emplace(frames, std::make_unique<FrameLoader>(frames), sample);
  }
  // Waits for the requested frame and returns its index.
  std::size_t wait(double now = 0) {
    if (!playback->isUpToDate()) playback->loader().wait(playback->requested());
    playback->take(now);
    return *playback->current();
  }

  std::shared_ptr<FakeFrames> frames;
  std::optional<Playback> playback;
};

TEST(Playback, StartsWithTheSampleOrTheMiddleOne) {
  Player named(5, "sample-103");
  EXPECT_EQ(named.playback->current(), std::nullopt);
  EXPECT_EQ(named.wait(), 3u);
  EXPECT_EQ(Player(5, "").wait(), 2u);
  EXPECT_THROW(Player(5, "no such sample"), InputError);
}

TEST(Playback, StepsAsFarAsThereAreFrames) {
  Player player(5);
  player.wait();
  EXPECT_FALSE(player.playback->stepBy(-1));
  EXPECT_TRUE(player.playback->stepBy(3));
  EXPECT_EQ(player.wait(), 3u);
  EXPECT_TRUE(player.playback->stepBy(10));
  EXPECT_EQ(player.wait(), 4u);
  EXPECT_FALSE(player.playback->stepBy(1));
  player.playback->goTo(99, 1);
  EXPECT_EQ(player.playback->requested(), 4u);
}

TEST(Playback, TakesAFrameOnceItIsLoaded) {
  Player player(3);
  player.wait();
  player.frames->setOpen(false);
  player.playback->goTo(2, 0);
  EXPECT_EQ(player.playback->take(0), nullptr);
  EXPECT_FALSE(player.playback->isUpToDate());
  EXPECT_EQ(player.playback->current(), 0u) << "the old frame stays until the new one is loaded";
  player.frames->setOpen(true);
  player.playback->loader().wait(2);
  const auto frame = player.playback->take(0);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->key, "sample-102");
  EXPECT_EQ(player.playback->take(0), nullptr) << "each frame is given out once";
}

// The frames are 0.1 s apart: they are played as they were recorded.
TEST(Playback, PlaysAtTheRecordedPace) {
  Player player(8);
  player.wait(10);
  player.playback->stepBy(1);
  player.wait(10);  // from here on the time between two frames is known
  player.playback->togglePlaying(10);
  EXPECT_TRUE(player.playback->playing());
  player.playback->tick(10.09);
  EXPECT_TRUE(player.playback->isUpToDate());
  EXPECT_TRUE(player.playback->tick(10.11));
  EXPECT_EQ(player.playback->requested(), 2u);
  player.wait(10.11);
  player.playback->tick(10.22);
  EXPECT_EQ(player.playback->requested(), 3u);
  player.playback->tick(99);
  EXPECT_EQ(player.playback->requested(), 3u) << "no frame is passed over while one is loading";
}

TEST(Playback, EndsAtTheLastFrameAndBeginsAnew) {
  Player player(3, "#2");
  player.wait(0);
  player.playback->togglePlaying(0);
  EXPECT_EQ(player.playback->requested(), 0u) << "after the last frame it plays from the start";
  for (double now = 1; player.playback->playing() && now < 10; now += 1) {
    player.wait(now);
    player.playback->tick(now + 0.5);
  }
  EXPECT_FALSE(player.playback->playing());
  EXPECT_EQ(player.wait(), 2u);
}

}  // namespace
}  // namespace scanmill
