// Panels on a canvas in memory: what is seen, and what a press means.

#include "viewer/panels/widgets.h"

#include <set>

#include "tests/studio/viewer/window/fake_canvas.h"
#include "viewer/color_map.h"
#include "viewer/panels/panel_rects.h"

namespace scanmill {
namespace {

constexpr Rgb kRoad{200, 30, 40};
constexpr Rgb kCarColor{30, 60, 220};
constexpr Rgb kTreeColor{20, 190, 60};

class PanelParts : public testing::Test {
 protected:
  void draw(const std::function<void()>& panels) {
    for (int i = 0; i < 2; ++i) imgui_.frame(panels);
  }
  void event(CanvasEvent::Kind kind, int x, int y, double amount = 0) {
    imgui_.take({.kind = kind, .x = x, .y = y, .button = 1, .amount = amount});
  }
  std::ptrdiff_t count(const Rgb& color, const PixelRect& rect = {0, 0, kWidth, kHeight}) const {
    std::ptrdiff_t found = 0;
    for (int y = rect.top; y < rect.top + rect.height; ++y) {
      for (int x = rect.left; x < rect.left + rect.width; ++x) found += canvas_.isOverlay(x, y, color) ? 1 : 0;
    }
    return found;
  }
  std::ptrdiff_t written() const {
    return std::ranges::count_if(canvas_.overlay(), [](const Rgba& o) { return o[3] != 0; });
  }

  static Legend classes() {
    return {.title = "class",
            .entries = {{"road", kRoad, 1, 123456}, {"car", kCarColor, 6, 789}, {"tree", kTreeColor, 9, 0}}};
  }

  static constexpr int kWidth = 500;
  static constexpr int kHeight = 300;
  FakeCanvas canvas_{kWidth, kHeight};
  ImGuiLayer imgui_{canvas_, 15};
};

TEST_F(PanelParts, AreNowhereWhereNothingIsSaid) {
  draw([] {});
  EXPECT_EQ(written(), 0);
  event(CanvasEvent::Kind::Move, 30, 30);
  draw([] {});
  EXPECT_FALSE(imgui_.hasPointer());
}

TEST_F(PanelParts, StandWhereTheyShallAndHaveThePointerThere) {
  const PixelRect rect{100, 50, 200, 100};
  const auto panel = [&] { panelAt("panel", rect, PanelUse::Interactive, [] { textLine("word"); }); };
  draw(panel);
  EXPECT_EQ(written(), 200 * 100);
  for (const auto& [x, y, inside] : {std::tuple(101, 51, true), std::tuple(298, 148, true), std::tuple(98, 60, false),
                                     std::tuple(200, 152, false)}) {
    event(CanvasEvent::Kind::Move, x, y);
    draw(panel);
    EXPECT_EQ(imgui_.hasPointer(), inside) << x << ", " << y;
  }
}

// Each entry has a sample of its colour, filled while it is shown; a press on its row says which it was.
TEST_F(PanelParts, RowsOfALegendShowAndTell) {
  std::vector<bool> hidden{false, true, false};
  LegendClick use;
  const auto panel = [&] {
    panelAt("panel", {0, 0, 300, 300}, PanelUse::Interactive, [&] {
      const LegendClick now = drawLegendRows(classes(), hidden, true, PanelUse::Interactive);
      if (now.allEntries || now.entry) use = now;
    });
  };
  draw(panel);
  const auto filled = count(kRoad);
  EXPECT_GT(filled, 80);
  EXPECT_EQ(count(kTreeColor), filled) << "of this frame there are none, but it is not hidden";
  EXPECT_EQ(count(kCarColor), 0);
  hidden.clear();
  draw(panel);
  for (const auto& [color, entry] : {std::pair(kRoad, 0u), std::pair(kCarColor, 1u), std::pair(kTreeColor, 2u)}) {
    const auto sample = canvas_.inOverlay(color);
    ASSERT_TRUE(sample);
    const int x = sample->first + 60, y = sample->second + 3;  // the whole row counts
    use = {};
    event(CanvasEvent::Kind::Down, x, y);
    imgui_.frame(panel);
    EXPECT_EQ(use.entry, entry);
    event(CanvasEvent::Kind::Up, x, y);
    imgui_.frame(panel);
  }
  use = {};
  event(CanvasEvent::Kind::Down, 40, 15);
  imgui_.frame(panel);
  EXPECT_TRUE(use.allEntries);
}

// In a picture nothing can be scrolled to: what has no room is counted, and what the frame lacks is left out.
TEST_F(PanelParts, PicturesNameWhatThereIsRoomFor) {
  Legend many;
  for (int i = 0; i < 40; ++i) {
    many.entries.push_back({"class", {static_cast<std::uint8_t>(60 + i), 10, 200}, i, i % 2 == 0 ? 10u : 0u});
  }
  const auto shown = [&](int height) {
    draw([&] {
      panelAt("panel", {0, 0, 300, height}, PanelUse::Picture,
              [&] { drawLegendRows(many, {}, false, PanelUse::Picture); });
    });
    int found = 0;
    for (const LegendEntry& entry : many.entries) {
      const bool seen = count(entry.color) > 20;
      EXPECT_FALSE(seen && entry.points == 0);
      found += seen ? 1 : 0;
    }
    return found;
  };
  const int few = shown(100);
  EXPECT_GE(few, 2);
  EXPECT_LE(few, 5);
  EXPECT_GT(shown(200), few);
}

// From left to right the colours of the map, at its whole width.
TEST_F(PanelParts, AScaleHasTheColoursOfTheMap) {
  const Legend legend{.title = "range (m)", .scale = true, .high = 50};
  draw([&] {
    panelAt("panel", {0, 0, 400, 200}, PanelUse::Interactive, [&] { drawScale(legend, PanelUse::Picture); });
  });
  int row = 0;
  while (row < 100 && !canvas_.isOverlay(200, row, canvas_.read().at(200, row))) ++row;
  const Image image = canvas_.read();
  const auto difference = [](const Rgb& a, const Rgb& b) {
    return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
  };
  // Where the bar is: from the first to the last pixel of a row that is far from the panel's own colour.
  int best = 0;
  for (int y = 5; y < 60; ++y) {
    int close = 0;
    for (int x = 12; x < 388; ++x) close += difference(image.at(x, y), viridis((x - 8.5) / 383.0)) < 12 ? 1 : 0;
    best = std::max(best, close);
  }
  EXPECT_GT(best, 340) << "of 376 pixels";
}

TEST_F(PanelParts, MessagesAreReadAndClickedAway) {
  std::vector<std::string> problems{"shard.tar: is damaged"};
  bool closed = false;
  const auto panel = [&] { closed = drawMessages({0, 0, kWidth, kHeight}, problems, {"saved"}) || closed; };
  draw(panel);
  const auto both = written();
  EXPECT_GT(both, 1000);
  event(CanvasEvent::Kind::Down, 30, kHeight - 20);
  imgui_.frame(panel);
  EXPECT_TRUE(closed);
  problems.clear();
  draw(panel);
  EXPECT_LT(written(), both);
}

// Whatever is said, in whatever room.
TEST_F(PanelParts, AnyTextAndAnySizeWillDo) {
  const std::string texts[] = {"",
                               "%s %n",
                               std::string(3000, 'x'),
                               "\xff\xfe\x80",
                               "Stra\xc3\x9f"
                               "e \xe4\xb8\xad",
                               "a\nb##c"};
  for (const int width : {64, 200, 900}) {
    canvas_.resize(width, 64 + width / 3);
    for (const std::string& text : texts) {
      const PixelRect all{0, 0, canvas_.width(), canvas_.height()};
      Legend legend = classes();
      legend.entries[0].name = text;
      EXPECT_NO_THROW(draw([&] {
        titleRow({0, 0, width, 20}, text, text);
        drawLabels({{-5, 3, text, all, true}, {1e9, 0, text, all, true}, {10, 10, text, all, false}});
        drawCaption(all, text, true);
        drawMessage(all, text);
        panelAt("side", {width / 2, 0, width / 2, 60}, PanelUse::Interactive, [&] {
          drawLegendRows(legend, {}, true, PanelUse::Interactive);
          heading(text, kRoad);
          valueRows("rows", {{text, text}, {"name", text}}, text);
        });
        tooltip(text, kCarColor, {{text, text}}, text);
        drawMessages(all, {text, text}, std::vector<std::string>(9, text));
        helpWindow({{text, text}});
      })) << width;
    }
  }
}

bool overlap(const PixelRect& a, const PixelRect& b) {
  return a.width > 0 && b.width > 0 && a.height > 0 && b.height > 0 && a.left < b.left + b.width &&
         b.left < a.left + a.width && a.top < b.top + b.height && b.top < a.top + a.height;
}

long areaOf(const PixelRect& rect) {
  return static_cast<long>(std::max(rect.width, 0)) * std::max(rect.height, 0);
}

// Together they fill the canvas, none lies over another, and something is left for the views, at every size.
TEST(PanelRects, FillTheCanvasAndLeaveABody) {
  for (int width = 1; width < 2000; width += 37) {
    for (int height = 1; height < 1200; height += 31) {
      for (int kinds = 0; kinds < 16; ++kinds) {
        const PanelNeeds needs{.title = (kinds & 1) != 0,
                               .side = (kinds & 2) != 0,
                               .bar = (kinds & 4) != 0,
                               .stripHeight = (kinds & 8) != 0 ? stripHeight(64, width, height) : 0};
        const PanelRects rects = panelRects(width, height, needs);
        const PixelRect all[] = {rects.title, rects.side, rects.strip, rects.bar, rects.body};
        long area = 0;
        for (const PixelRect& rect : all) {
          area += areaOf(rect);
          for (const PixelRect& other : all) {
            ASSERT_TRUE(&rect == &other || !overlap(rect, other)) << width << " x " << height << ", " << kinds;
          }
        }
        ASSERT_EQ(area, static_cast<long>(width) * height) << width << " x " << height << ", " << kinds;
        ASSERT_GE(rects.body.width, 1);
        ASSERT_GE(rects.body.height, 1);
        if (width > 600 && height > 400) {
          EXPECT_EQ(rects.side.width > 0, needs.side);
          EXPECT_GT(areaOf(rects.body), area / 4);
        }
      }
    }
  }
}

TEST(PanelRects, PartsAreAlikeAndFillTheBody) {
  for (const PixelRect& body : {PixelRect{0, 20, 1300, 700}, PixelRect{3, 5, 200, 900}, PixelRect{0, 0, 7, 5}}) {
    for (std::size_t parts = 1; parts <= kCanvasViews; ++parts) {
      const auto rects = gridRects(body, parts);
      ASSERT_EQ(rects.size(), parts);
      long area = 0;
      for (const PixelRect& rect : rects) {
        ASSERT_GE(rect.width, 1);
        ASSERT_GE(rect.height, 1);
        EXPECT_LE(std::abs(rect.width - rects[0].width), 1);
        EXPECT_LE(std::abs(rect.height - rects[0].height), 1);
        area += areaOf(rect);
        for (const PixelRect& other : rects) {
          EXPECT_TRUE(&rect == &other || body.width < 100 || !overlap(rect, other));
        }
      }
      EXPECT_TRUE(body.width < 100 || area > areaOf(body) * 97 / 100);
    }
  }
}

TEST(PanelRects, StripsHaveTheirRowsInWholeSteps) {
  for (const int rings : {16, 32, 64, 128}) {
    const int height = stripHeight(rings, 1600, 1000);
    EXPECT_LE(height, 200);
    EXPECT_EQ(height % rings, 0) << rings;
  }
  EXPECT_EQ(stripHeight(4000, 700, 1000), 100) << "more rows than pixels";
}

}  // namespace
}  // namespace scanmill
