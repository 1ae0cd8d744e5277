#include <gtest/gtest.h>

#include <cmath>

#include "viewer/window/hud.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {
namespace {

HudState stateOf(int width, int height, std::size_t panes) {
  HudState state;
  state.width = width;
  state.height = height;
  state.panes.resize(panes);
  state.frame = 3;
  state.frames = 10;
  return state;
}

int shared(const PixelRect& a, const PixelRect& b) {
  const int width = std::min(a.left + a.width, b.left + b.width) - std::max(a.left, b.left);
  const int height = std::min(a.top + a.height, b.top + b.height) - std::max(a.top, b.top);
  return std::max(width, 0) * std::max(height, 0);
}

TEST(HudLayout, PanesTileTheirPlace) {
  for (const auto& [width, height] : {std::pair(1600, 900), {800, 600}, {600, 900}, {3840, 2160}, {64, 64}}) {
    for (std::size_t panes = 1; panes <= 8; ++panes) {
      HudState state = stateOf(width, height, panes);
      state.strip = HudStrip{Image(100, 16, {}), {}, "strip"};
      const HudLayout layout = layoutHud(state);
      ASSERT_EQ(layout.panes.size(), panes);
      long area = 0;
      int left = width, top = height, right = 0, bottom = 0;
      for (std::size_t i = 0; i < panes; ++i) {
        const PixelRect& pane = layout.panes[i];
        EXPECT_GE(pane.width, 1);
        EXPECT_GE(pane.height, 1);
        EXPECT_EQ(shared(pane, layout.strip), 0);
        for (std::size_t k = 0; k < i; ++k) EXPECT_EQ(shared(pane, layout.panes[k]), 0);
        area += static_cast<long>(pane.width) * pane.height;
        left = std::min(left, pane.left);
        top = std::min(top, pane.top);
        right = std::max(right, pane.left + pane.width);
        bottom = std::max(bottom, pane.top + pane.height);
      }
      EXPECT_EQ(left, 0);
      EXPECT_EQ(right, width);
      EXPECT_LE(bottom, height);
      const double whole = static_cast<double>(right - left) * (bottom - top);
      EXPECT_GT(static_cast<double>(area), whole * (width > 64 ? 0.97 : 0.8)) << panes << " panes";
    }
  }
}

TEST(HudLayout, TwoStandSideBySideAndFourInASquare) {
  const std::vector<PixelRect> two = layoutHud(stateOf(1600, 900, 2)).panes;
  EXPECT_EQ(two[0].top, two[1].top);
  EXPECT_LT(two[0].left, two[1].left);
  EXPECT_NEAR(two[0].width, two[1].width, 1);
  const std::vector<PixelRect> four = layoutHud(stateOf(1600, 900, 4)).panes;
  EXPECT_EQ(four[0].top, four[1].top);
  EXPECT_EQ(four[0].left, four[2].left);
  EXPECT_LT(four[0].top, four[2].top);
  const std::vector<PixelRect> tall = layoutHud(stateOf(600, 900, 2)).panes;
  EXPECT_EQ(tall[0].left, tall[1].left);
}

TEST(HudLayout, PanesAreOfOneSize) {
  for (const auto& [width, height] : {std::pair(1280, 800), {1600, 900}, {800, 1000}, {1000, 1000}, {2560, 1080}}) {
    for (std::size_t count = 2; count <= 6; ++count) {
      const std::vector<PixelRect> panes = layoutHud(stateOf(width, height, count)).panes;
      for (const PixelRect& pane : panes) {
        EXPECT_NEAR(pane.width, panes[0].width, 1) << count;
        EXPECT_NEAR(pane.height, panes[0].height, 1) << count;
      }
    }
  }
}

TEST(HudLayout, PicturesHaveNoBar) {
  HudState state = stateOf(1600, 900, 1);
  const int before = layoutHud(state).panes[0].height;
  state.still = true;
  const PixelRect pane = layoutHud(state).panes[0];
  EXPECT_GT(pane.height, before);
  EXPECT_EQ(pane.top + pane.height, 900);
  for (const HudRegion& region : drawHud(state).regions) {
    EXPECT_NE(region.part, HudPart::Slider);
    EXPECT_NE(region.part, HudPart::PlayButton);
    EXPECT_NE(region.part, HudPart::Help);
  }
}

TEST(HudLayout, NothingJumpsForWhatComesAndGoes) {
  const HudState plain = stateOf(1000, 700, 2);
  HudState state = plain;
  state.tip = HudTip{3, 3, "car", {}, {{"class", "car"}}};
  state.help = true;
  state.keys = {{"h", "help"}};
  state.problems = {"a", "b"};
  state.notices = {"c"};
  state.busy = "a frame";
  state.prompt = "text";
  state.labels = {{5, 5, "label", {}, true}};
  state.key = std::string(200, 'k');
  state.playing = true;
  const HudLayout before = layoutHud(plain);
  const HudLayout after = layoutHud(state);
  EXPECT_EQ(before.panes, after.panes);
  EXPECT_EQ(before.cell, after.cell);
  const HudFrame a = frameOf(plain);
  const HudFrame b = frameOf(state);
  EXPECT_EQ(a.slider, b.slider);
  EXPECT_EQ(a.play, b.play);
}

TEST(HudLayout, TheSliderGoesBackToTheFrameItShows) {
  for (const int width : {400, 800, 1600}) {
    for (const std::size_t frames : {1u, 2u, 3u, 60u, 150u}) {
      HudState state = stateOf(width, 600, 1);
      const PixelRect slider = frameOf(state).slider;
      for (std::size_t frame = 0; frame < frames; ++frame) {
        const int x = static_cast<int>(std::floor(knobAt(slider, frames, frame)));
        EXPECT_TRUE(slider.contains(x, slider.top));
        EXPECT_EQ(sliderFrame(slider, frames, x), frame) << frames;
      }
      EXPECT_EQ(sliderFrame(slider, frames, -1000), 0u);
      EXPECT_EQ(sliderFrame(slider, frames, 100000), frames - 1);
    }
  }
  EXPECT_EQ(sliderFrame({}, 10, 5), 0u);
  EXPECT_EQ(sliderFrame({0, 0, 100, 20}, 0, 50), 0u);
}

TEST(HudLayout, PicturesKeepTheirShape) {
  for (const auto& [columns, rows] : {std::pair(640, 480), {64, 64}, {1920, 1080}, {100, 700}}) {
    HudState state = stateOf(1600, 900, 1);
    state.picture = HudStrip{Image(columns, rows, {}), {}, "depth"};
    const HudLayout layout = layoutHud(state);
    EXPECT_NEAR(static_cast<double>(layout.picture.width) / columns, static_cast<double>(layout.picture.height) / rows,
                1.0 / std::min(columns, rows));
    EXPECT_EQ(shared(layout.picture, layout.panes[0]), layout.picture.width * layout.picture.height);
    EXPECT_GT(std::max(layout.picture.width / 1600.0, layout.picture.height / 820.0), 0.7) << "as large as fits";
  }
  HudState flat = stateOf(1600, 900, 1);
  flat.picture = HudStrip{Image(2048, 16, {}), {}, "hits"};
  EXPECT_GT(layoutHud(flat).picture.height, 200) << "rings that one can tell apart";
}

TEST(HudLayout, RowsOfAStripAreAllAlikeWhereThereIsRoom) {
  HudState state = stateOf(1600, 900, 1);
  for (const int rings : {1, 16, 32, 64, 128}) {
    state.strip = HudStrip{Image(2048, rings, {}), {}, "range image"};
    const PixelRect strip = layoutHud(state).strip;
    EXPECT_EQ(strip.height % rings, 0);
    EXPECT_EQ(strip.width, 1600);
  }
  state.strip.reset();
  EXPECT_EQ(layoutHud(state).strip, PixelRect{});
}

}  // namespace
}  // namespace scanmill
