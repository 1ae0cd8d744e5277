#include "tests/studio/viewer/window/fake_canvas.h"
#include "viewer/window/session_context.h"

namespace scanmill {
namespace {

// A canvas whose pictures take a time that follows from the number of their points.
class SlowCanvas : public FakeCanvas {
 public:
  static constexpr double kPointsPerSecond = 1e6;

  SlowCanvas() : FakeCanvas(64, 48) {}
  void render(std::uint64_t maxPoints) override {
    FakeCanvas::render(maxPoints);
    now += static_cast<double>(maxPoints == 0 ? points : std::min(points, maxPoints)) / kPointsPerSecond;
  }

  double now = 1;            // s
  std::uint64_t points = 0;  // of the only item
};

struct DrawnWorld {
  explicit DrawnWorld(std::uint64_t points) : redraw(canvas, [this] { return canvas.now; }) { canvas.points = points; }
  void draw(Detail detail = Detail::Fast) { redraw.draw(detail, canvas.points, 1, canvas.now); }

  SlowCanvas canvas;
  RedrawScheduler redraw;
};

constexpr std::uint64_t kFew = 1000;
constexpr std::uint64_t kMany = 20'000'000;

TEST(RedrawScheduler, DrawsOnlyWhatHasChanged) {
  DrawnWorld world(kFew);
  world.draw();
  EXPECT_EQ(world.canvas.renders, 1);
  world.draw();
  world.redraw.changes.hover = true;  // alone, it may have changed nothing
  world.draw();
  EXPECT_EQ(world.canvas.renders, 1);
  EXPECT_TRUE(world.redraw.changes.hover) << "whoever looks for what is under the pointer resets it";
  for (bool* const change : {&world.redraw.changes.views, &world.redraw.changes.items, &world.redraw.changes.panels,
                             &world.redraw.changes.highlight}) {
    const int before = world.canvas.renders;
    *change = true;
    world.draw();
    EXPECT_EQ(world.canvas.renders, before + 1);
    EXPECT_FALSE(*change);
  }
}

// While something moves, a picture has as many points as 30 ms allow, measured; afterwards all of them.
TEST(RedrawScheduler, LimitsPointsUntilNothingMoves) {
  DrawnWorld world(kMany);
  for (int picture = 0; picture < 20; ++picture) {
    world.redraw.changes.views = true;
    world.draw();
  }
  EXPECT_GT(world.canvas.lastMost, 0u);
  EXPECT_LT(world.canvas.lastMost, kMany / 10) << "20 million points would take 20 s";
  EXPECT_FALSE(world.redraw.allPointsDue()) << "it has just been drawn";
  world.canvas.now += 1;
  EXPECT_TRUE(world.redraw.allPointsDue());
  world.draw(Detail::AllPoints);
  EXPECT_EQ(world.canvas.lastMost, 0u);
  EXPECT_TRUE(world.redraw.isSlow());
  world.canvas.now += 100;
  EXPECT_FALSE(world.redraw.allPointsDue()) << "all points are drawn";
  // The longer all points take, the longer it waits before it draws them again.
  world.redraw.changes.views = true;
  world.draw();
  world.canvas.now += 5;
  EXPECT_FALSE(world.redraw.allPointsDue());
  world.canvas.now += 10;
  EXPECT_TRUE(world.redraw.allPointsDue());
}

TEST(RedrawScheduler, KeepsTheLimitWhereOnlyPanelsChange) {
  DrawnWorld world(kMany);
  world.draw();
  const std::uint64_t most = world.canvas.lastMost;
  ASSERT_GT(most, 0u);
  world.redraw.changes.panels = true;
  world.draw();
  EXPECT_EQ(world.canvas.lastMost, most);
}

TEST(RedrawScheduler, DrawsFewPointsAllAtOnce) {
  DrawnWorld world(kFew);
  world.draw();
  EXPECT_EQ(world.canvas.lastMost, 0u);
  world.canvas.now += 100;
  EXPECT_FALSE(world.redraw.allPointsDue());
  EXPECT_FALSE(world.redraw.isSlow());
}

// Moves of the pointer in quick succession are drawn together, in slow pictures more of them.
TEST(RedrawScheduler, FollowsThePointerAsFastAsItDraws) {
  DrawnWorld quick(kFew);
  quick.draw();
  quick.canvas.now += 0.011;
  EXPECT_FALSE(quick.redraw.mayFollowPointer());
  quick.canvas.now += 0.002;
  EXPECT_TRUE(quick.redraw.mayFollowPointer());
  DrawnWorld slow(kMany);
  slow.draw(Detail::AllPoints);
  slow.canvas.now += 19;
  EXPECT_FALSE(slow.redraw.mayFollowPointer());
  slow.canvas.now += 2;
  EXPECT_TRUE(slow.redraw.mayFollowPointer());
}

TEST(RedrawScheduler, GivesTheCanvasNewRectanglesAndCameras) {
  DrawnWorld world(kFew);
  CanvasView view{.rect = {0, 0, 64, 48}};
  world.redraw.setViews({view});
  world.draw();
  view.background = {1, 2, 3};
  world.redraw.setViews({view});
  EXPECT_FALSE(world.redraw.changes.views) << "nothing said that a view has changed";
  view.rect.width = 32;
  world.redraw.setViews({view});
  EXPECT_TRUE(world.redraw.changes.views) << "panels have taken room from the view";
  EXPECT_EQ(world.canvas.views().front().rect.width, 32);
}

}  // namespace
}  // namespace scanmill
