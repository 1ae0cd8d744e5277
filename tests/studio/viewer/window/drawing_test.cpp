#include "viewer/window/drawing.h"

#include "tests/studio/viewer/window/fake_canvas.h"

namespace scanmill {
namespace {

// A canvas whose pictures take a time that follows from the number of their points.
class SlowCanvas : public FakeCanvas {
 public:
  static constexpr double kPointsPerSecond = 1e6;

  SlowCanvas() : FakeCanvas(64, 48) {}
  void render(std::uint64_t mostPoints) override {
    FakeCanvas::render(mostPoints);
    now += static_cast<double>(mostPoints == 0 ? points : std::min(points, mostPoints)) / kPointsPerSecond;
  }

  double now = 1;            // s
  std::uint64_t points = 0;  // of the only item
};

struct DrawnWorld {
  explicit DrawnWorld(std::uint64_t points) : drawing(canvas, [this] { return canvas.now; }) { canvas.points = points; }
  void draw(bool whole = false) { drawing.draw(whole, canvas.points, 1, canvas.now); }

  SlowCanvas canvas;
  Drawing drawing;
};

constexpr std::uint64_t kFew = 1000;
constexpr std::uint64_t kMany = 20'000'000;

TEST(Drawing, DrawsOnlyWhatHasChanged) {
  DrawnWorld world(kFew);
  world.draw();
  EXPECT_EQ(world.canvas.renders, 1);
  world.draw();
  world.drawing.changes.hover = true;  // alone, it may have changed nothing
  world.draw();
  EXPECT_EQ(world.canvas.renders, 1);
  EXPECT_TRUE(world.drawing.changes.hover) << "whoever looks for what is under the pointer resets it";
  for (bool* const change : {&world.drawing.changes.views, &world.drawing.changes.items, &world.drawing.changes.panels,
                             &world.drawing.changes.light}) {
    const int before = world.canvas.renders;
    *change = true;
    world.draw();
    EXPECT_EQ(world.canvas.renders, before + 1);
    EXPECT_FALSE(*change);
  }
}

// While something moves, a picture has as many points as 30 ms allow, measured; afterwards all of them.
TEST(Drawing, LimitsPointsUntilNothingMoves) {
  DrawnWorld world(kMany);
  for (int picture = 0; picture < 20; ++picture) {
    world.drawing.changes.views = true;
    world.draw();
  }
  EXPECT_GT(world.canvas.lastMost, 0u);
  EXPECT_LT(world.canvas.lastMost, kMany / 10) << "20 million points would take 20 s";
  EXPECT_FALSE(world.drawing.wholeIsDue()) << "it has just been drawn";
  world.canvas.now += 1;
  EXPECT_TRUE(world.drawing.wholeIsDue());
  world.draw(true);
  EXPECT_EQ(world.canvas.lastMost, 0u);
  EXPECT_TRUE(world.drawing.slow());
  world.canvas.now += 100;
  EXPECT_FALSE(world.drawing.wholeIsDue()) << "all points are drawn";
  // The longer all points take, the longer it waits before it draws them again.
  world.drawing.changes.views = true;
  world.draw();
  world.canvas.now += 5;
  EXPECT_FALSE(world.drawing.wholeIsDue());
  world.canvas.now += 10;
  EXPECT_TRUE(world.drawing.wholeIsDue());
}

TEST(Drawing, KeepsTheLimitWhereOnlyPanelsChange) {
  DrawnWorld world(kMany);
  world.draw();
  const std::uint64_t most = world.canvas.lastMost;
  ASSERT_GT(most, 0u);
  world.drawing.changes.panels = true;
  world.draw();
  EXPECT_EQ(world.canvas.lastMost, most);
}

TEST(Drawing, DrawsFewPointsAllAtOnce) {
  DrawnWorld world(kFew);
  world.draw();
  EXPECT_EQ(world.canvas.lastMost, 0u);
  world.canvas.now += 100;
  EXPECT_FALSE(world.drawing.wholeIsDue());
  EXPECT_FALSE(world.drawing.slow());
}

// Moves of the pointer in quick succession are drawn together, in slow pictures more of them.
TEST(Drawing, FollowsThePointerAsFastAsItDraws) {
  DrawnWorld quick(kFew);
  quick.draw();
  quick.canvas.now += 0.011;
  EXPECT_FALSE(quick.drawing.mayFollowPointer());
  quick.canvas.now += 0.002;
  EXPECT_TRUE(quick.drawing.mayFollowPointer());
  DrawnWorld slow(kMany);
  slow.draw(true);
  slow.canvas.now += 19;
  EXPECT_FALSE(slow.drawing.mayFollowPointer());
  slow.canvas.now += 2;
  EXPECT_TRUE(slow.drawing.mayFollowPointer());
}

TEST(Drawing, GivesTheCanvasNewRectanglesAndCameras) {
  DrawnWorld world(kFew);
  CanvasView view{.rect = {0, 0, 64, 48}};
  world.drawing.setViews({view});
  world.draw();
  view.background = {1, 2, 3};
  world.drawing.setViews({view});
  EXPECT_FALSE(world.drawing.changes.views) << "nothing said that a view has changed";
  view.rect.width = 32;
  world.drawing.setViews({view});
  EXPECT_TRUE(world.drawing.changes.views) << "panels have taken room from the view";
  EXPECT_EQ(world.canvas.views().front().rect.width, 32);
}

}  // namespace
}  // namespace scanmill
