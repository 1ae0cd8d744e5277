#include "viewer/frames/frame_loader.h"

#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "tests/studio/viewer/window/fake_frames.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::size_t kPoints = 1000;
constexpr std::uint64_t kFrameBytes = kPoints * sizeof(Vec3f) + sizeof(ViewFrame) + sizeof(ViewScan);

// Frames of kPoints points at x = number, which note what is loaded of them.
class CountedFrames : public FakeFrames {
 public:
  explicit CountedFrames(std::size_t count) : FakeFrames(count) {
    for (std::size_t i = 0; i < count; ++i) {
      ViewScan scan;
      scan.scan.position.assign(kPoints, {float(i), 0, 0});
      frames[i].scans = {scan};
    }
  }

  ViewFrame load(std::size_t frame) const override {
    {
      const std::lock_guard lock(noting_);
      loaded_.push_back(frame);
    }
    begun_.notify_all();
    ViewFrame view = FakeFrames::load(frame);
    if (frame == 13) throw std::runtime_error("no memory");
    return view;
  }

  void waitUntilBegun(std::size_t count) const {
    std::unique_lock lock(noting_);
    begun_.wait(lock, [&] { return loaded_.size() >= count; });
  }
  std::vector<std::size_t> loaded() const {
    const std::lock_guard lock(noting_);
    return loaded_;
  }

 private:
  mutable std::mutex noting_;
  mutable std::condition_variable begun_;
  mutable std::vector<std::size_t> loaded_;
};

class Loader : public testing::Test {
 protected:
  std::shared_ptr<CountedFrames> source = std::make_shared<CountedFrames>(40);
};

TEST_F(Loader, GivesEveryFrame) {
  FrameLoader loader(source);
  for (const std::size_t frame : {7u, 3u, 39u, 0u, 3u}) {
    const auto loaded = loader.wait(frame);
    ASSERT_NE(loaded, nullptr);
    EXPECT_EQ(loaded->key, source->keys()[frame]);
    EXPECT_EQ(loaded->scans[0].scan.position[0].x, float(frame));
    EXPECT_EQ(loader.frame(frame), loaded);
  }
  EXPECT_EQ(source->loaded().size(), 4u);
  EXPECT_EQ(loader.frame(8), nullptr);
  EXPECT_EQ(loader.busy(), "");
}

TEST_F(Loader, ReadsAheadInTheDirectionOfStepping) {
  for (const int step : {1, -1}) {
    const std::size_t before = source->loaded().size();
    FrameLoader loader(source, 10 * kFrameBytes);
    loader.want(20, step);
    source->waitUntilBegun(before + 5);  // half of the room
    loader.wait(20 + static_cast<std::size_t>(4 * step));
    std::vector<std::size_t> loaded = source->loaded();
    loaded.erase(loaded.begin(), loaded.begin() + static_cast<std::ptrdiff_t>(before));
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(loaded[i], 20 + i * static_cast<std::size_t>(step));
  }
}

TEST_F(Loader, WithoutADirectionReadsNothingAhead) {
  const std::size_t before = source->loaded().size();
  FrameLoader loader(source);
  loader.want(20, 0);
  loader.wait(20);
  EXPECT_EQ(loader.busy(), "");
  loader.wait(3);  // its thread has had time for more
  EXPECT_EQ(source->loaded().size(), before + 2);
}

TEST_F(Loader, ReadsAheadToTheEndAndNoFurther) {
  for (const auto& [start, step] : {std::pair{37u, 1}, std::pair{2u, -1}}) {
    const std::size_t before = source->loaded().size();
    FrameLoader loader(source);
    loader.want(start, step);
    loader.wait(start);
    source->waitUntilBegun(before + 3);
    loader.wait(step > 0 ? 39 : 0);
    EXPECT_EQ(source->loaded().size(), before + 3);
  }
}

TEST_F(Loader, ReadsAheadNotTooFar) {
  const auto many = std::make_shared<CountedFrames>(1000);
  FrameLoader loader(many);
  loader.want(100);
  while (loader.frame(164) == nullptr) std::this_thread::yield();
  loader.wait(900);
  EXPECT_EQ(many->loaded().size(), 66u);
}

TEST_F(Loader, KeepsTheNearestFrames) {
  FrameLoader loader(source, 3 * kFrameBytes);
  for (const std::size_t frame : {0u, 1u, 2u}) loader.wait(frame);
  loader.wait(3);  // 0 goes
  EXPECT_EQ(loader.frame(0), nullptr);
  EXPECT_NE(loader.frame(1), nullptr);
  EXPECT_NE(loader.frame(2), nullptr);
  EXPECT_NE(loader.frame(3), nullptr);
}

TEST_F(Loader, TheWantedFrameStaysHoweverLarge) {
  FrameLoader loader(source, 1);
  loader.want(4);
  EXPECT_NE(loader.wait(4), nullptr);
  EXPECT_NE(loader.frame(4), nullptr);
  loader.want(5);
  EXPECT_NE(loader.wait(5), nullptr);
  EXPECT_EQ(loader.frame(4), nullptr);
}

TEST_F(Loader, TheNewestWishGoesFirst) {
  source->setOpen(false);
  FrameLoader loader(source, 1);
  loader.want(0);
  source->waitUntilBegun(1);
  EXPECT_EQ(loader.busy(), "sample-100");
  loader.want(1);
  loader.want(2);
  loader.want(30);
  EXPECT_EQ(loader.busy(), "sample-130");
  EXPECT_EQ(loader.frame(30), nullptr);
  source->setOpen(true);
  loader.wait(30);
  EXPECT_THAT(source->loaded(), ElementsAre(0, 30));
}

TEST_F(Loader, AFailureIsAProblemOfTheFrame) {
  FrameLoader loader(source);
  const auto frame = loader.wait(13);
  EXPECT_EQ(frame->key, "sample-113");
  EXPECT_THAT(frame->problems, ElementsAre("no memory"));
}

TEST_F(Loader, EndsAtAnyMoment) {
  for (int i = 0; i < 50; ++i) {
    FrameLoader loader(source);
    if (i % 2) loader.want(static_cast<std::size_t>(i % 40), i % 3 ? 1 : -1);
    if (i % 5 == 0) loader.wait(static_cast<std::size_t>(i % 40));
  }
  source->setOpen(false);
  auto loader = std::make_unique<FrameLoader>(source);
  const std::size_t before = source->loaded().size();
  loader->want(0);
  source->waitUntilBegun(before + 1);
  std::thread opener([&] { source->setOpen(true); });
  loader.reset();
  opener.join();
}

class MeshLoader : public Loader {
 protected:
  SceneChoice sceneOfBoxes(int boxes) const {
    std::string text = kSceneHead;
    for (int i = 0; i < boxes; ++i) {
      text += "  - {primitive: box, size: [1, 1, 1], class: wall, material: brick, position: [" +
              std::to_string(2 * i) + ", 0, 0]}\n";
    }
    return {folder.write("boxes" + std::to_string(boxes) + ".yaml", text), 1};
  }

  TemporaryFolder folder;
};

TEST_F(MeshLoader, LoadsOneScene) {
  FrameLoader loader(source);
  const SceneChoice two = sceneOfBoxes(2);
  const SceneChoice three = sceneOfBoxes(3);
  EXPECT_EQ(loader.mesh(two), nullptr);
  loader.wantMesh(two);
  const auto mesh = loader.waitMesh(two);
  EXPECT_EQ(mesh->problem, "");
  EXPECT_EQ(mesh->size(), 24u);
  EXPECT_EQ(loader.mesh(two), mesh);
  EXPECT_EQ(loader.waitMesh(three)->size(), 36u);
  EXPECT_EQ(loader.mesh(two), nullptr);
  EXPECT_EQ(loader.mesh({three.file, 2}), nullptr);
  EXPECT_THAT(loader.waitMesh({folder.path() / "none.yaml", 1})->problem, HasSubstr("none.yaml"));
  EXPECT_EQ(loader.busy(), "");
}

TEST_F(MeshLoader, FramesGoFirst) {
  const SceneChoice two = sceneOfBoxes(2);
  source->setOpen(false);
  FrameLoader loader(source, 1);
  loader.wantMesh(two);
  loader.want(3);
  source->waitUntilBegun(1);
  EXPECT_EQ(loader.busy(), "sample-103");
  source->setOpen(true);
  loader.wait(3);
  EXPECT_EQ(loader.waitMesh(two)->size(), 24u);
}

}  // namespace

}  // namespace scanmill
