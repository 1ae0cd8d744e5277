#include "viewer/window/hud.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "viewer/color_map.h"
#include "viewer/window/hud_paint.h"

namespace scanmill {
namespace {

constexpr Rgb kRoad{200, 30, 40};
constexpr Rgb kCar{30, 60, 220};
constexpr Rgb kTree{20, 190, 60};

HudState oneView(int width, int height) {
  HudState state;
  state.width = width;
  state.height = height;
  state.title = "a dataset";
  state.summary = "class";
  HudPane& pane = state.panes.emplace_back();
  pane.caption = "top, ray_tracing";
  pane.legend.title = "class";
  pane.legend.entries = {{"road", kRoad, 1, 123456}, {"car", kCar, 6, 789}, {"tree", kTree, 9, 0}};
  pane.clickable = true;
  state.frame = 12;
  state.frames = 60;
  state.key = "street-s1-lane-000012";
  state.keys = {{"h", "help"}, {"c", "colour by the next column"}, {"Space", "play and stop"}};
  return state;
}

const Rgba& pixelAt(const Hud& hud, const HudState& state, int x, int y) {
  return hud.pixels.at(static_cast<std::size_t>(y) * static_cast<std::size_t>(state.width) +
                       static_cast<std::size_t>(x));
}

std::ptrdiff_t countIn(const Hud& hud, const HudState& state, const PixelRect& rect, const Rgb& color) {
  std::ptrdiff_t found = 0;
  for (int y = std::max(rect.top, 0); y < std::min(rect.top + rect.height, state.height); ++y) {
    for (int x = std::max(rect.left, 0); x < std::min(rect.left + rect.width, state.width); ++x) {
      found += pixelAt(hud, state, x, y) == Rgba{color[0], color[1], color[2], 255} ? 1 : 0;
    }
  }
  return found;
}

std::ptrdiff_t countAll(const Hud& hud, const HudState& state, const Rgb& color) {
  return countIn(hud, state, {0, 0, state.width, state.height}, color);
}

const HudRegion* regionOf(const Hud& hud, HudPart part, std::size_t entry = 0, std::size_t pane = 0) {
  const auto found = std::find_if(hud.regions.begin(), hud.regions.end(), [&](const HudRegion& r) {
    return r.part == part && r.entry == entry && r.pane == pane;
  });
  return found == hud.regions.end() ? nullptr : &*found;
}

// Smallest rectangle of what differs.
PixelRect changed(const Hud& a, const Hud& b, const HudState& state) {
  int left = state.width, top = state.height, right = 0, bottom = 0;
  for (int y = 0; y < state.height; ++y) {
    for (int x = 0; x < state.width; ++x) {
      if (pixelAt(a, state, x, y) == pixelAt(b, state, x, y)) continue;
      left = std::min(left, x);
      right = std::max(right, x + 1);
      top = std::min(top, y);
      bottom = std::max(bottom, y + 1);
    }
  }
  return {left, top, right - left, bottom - top};
}

bool holds(const PixelRect& outer, const PixelRect& inner) {
  return inner.left >= outer.left && inner.top >= outer.top && inner.left + inner.width <= outer.left + outer.width &&
         inner.top + inner.height <= outer.top + outer.height;
}

Image numbered(int width, int height) {
  Image image(width, height, {});
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at(x, y) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 77};
  }
  return image;
}

TEST(Hud, TheLegendShowsColoursWhereTheyAreClicked) {
  for (const auto& [width, height] : {std::pair(1600, 900), {800, 600}, {3840, 2160}}) {
    const HudState state = oneView(width, height);
    const Hud hud = drawHud(state);
    const Rgb colors[] = {kRoad, kCar, kTree};
    for (std::size_t i = 0; i < 3; ++i) {
      const HudRegion* row = regionOf(hud, HudPart::Legend, i);
      ASSERT_NE(row, nullptr);
      const std::ptrdiff_t swatch = countIn(hud, state, row->rect, colors[i]);
      EXPECT_GE(swatch, 7 * 7) << width;
      EXPECT_EQ(swatch, countAll(hud, state, colors[i])) << "nothing of it is outside of its row";
      EXPECT_EQ(regionAt(hud, row->rect.left + 2, row->rect.top + row->rect.height / 2), row);
    }
    EXPECT_NE(regionOf(hud, HudPart::LegendAll), nullptr);
    const PixelRect first = regionOf(hud, HudPart::Legend, 0)->rect;
    EXPECT_EQ(first.top + first.height / 2 > height / 2, false) << "in the upper corner";
    EXPECT_GT(first.left, width / 2) << "on the right";
  }
}

TEST(Hud, AHiddenEntrysColourIsGoneAndComesBack) {
  HudState state = oneView(1600, 900);
  const Hud all = drawHud(state);
  state.panes[0].hidden = {false, true, false};
  const Hud some = drawHud(state);
  EXPECT_EQ(countAll(some, state, kCar), 0);
  EXPECT_EQ(countAll(some, state, kRoad), countAll(all, state, kRoad));
  ASSERT_NE(regionOf(some, HudPart::Legend, 1), nullptr) << "it can be clicked again";
  EXPECT_EQ(regionOf(some, HudPart::Legend, 1)->rect, regionOf(all, HudPart::Legend, 1)->rect);
  state.panes[0].hidden = {};
  EXPECT_EQ(drawHud(state).pixels, all.pixels);
}

TEST(Hud, ALegendThatIsOnlyLookedAtCatchesNoClicks) {
  HudState state = oneView(1600, 900);
  state.panes[0].clickable = false;
  const Hud hud = drawHud(state);
  EXPECT_EQ(regionOf(hud, HudPart::Legend), nullptr);
  EXPECT_EQ(regionOf(hud, HudPart::LegendAll), nullptr);
  EXPECT_GT(countAll(hud, state, kRoad), 0);
}

// However many classes and panes: rows stand over no other rows, in their own pane, and what is left out is no region.
TEST(Hud, LegendsStayInTheirPanes) {
  for (const std::size_t entries : {1u, 27u, 400u}) {
    for (const std::size_t panes : {1u, 2u, 4u}) {
      HudState state = oneView(900, 500);
      LegendEntry entry{"a_class_name", kRoad, 1, 1000000};
      state.panes[0].legend.entries.assign(entries, entry);
      state.panes.resize(panes, state.panes[0]);
      const Hud hud = drawHud(state);
      const HudLayout layout = layoutHud(state);
      for (std::size_t i = 0; i < hud.regions.size(); ++i) {
        const HudRegion& a = hud.regions[i];
        if (a.part != HudPart::Legend && a.part != HudPart::LegendAll) continue;
        EXPECT_TRUE(holds(layout.panes[a.pane], a.rect));
        for (std::size_t k = 0; k < i; ++k) {
          const HudRegion& b = hud.regions[k];
          if (b.part != HudPart::Legend) continue;
          const bool apart = a.rect.left + a.rect.width <= b.rect.left || b.rect.left + b.rect.width <= a.rect.left ||
                             a.rect.top + a.rect.height <= b.rect.top + 1 ||
                             b.rect.top + b.rect.height <= a.rect.top + 1;
          ASSERT_TRUE(apart) << entries << " entries, " << panes << " panes, " << a.entry << " and " << b.entry;
        }
      }
      EXPECT_NE(regionOf(hud, HudPart::Legend, 0, panes - 1), nullptr);
      EXPECT_EQ(regionOf(hud, HudPart::Legend, 399), nullptr) << "there is no room for so many";
    }
  }
}

TEST(Hud, AScaleRunsFromLowToHigh) {
  HudState state = oneView(1600, 900);
  Legend& legend = state.panes[0].legend;
  legend = {};
  legend.title = "range (m)";
  legend.scale = true;
  legend.low = 1;
  legend.high = 80;
  const Hud hud = drawHud(state);
  const auto rowsOf = [&](const Rgb& color) {
    std::vector<int> rows;
    for (int y = 0; y < state.height; ++y) {
      if (countIn(hud, state, {0, y, state.width, 1}, color) > 4) rows.push_back(y);
    }
    return rows;
  };
  const std::vector<int> low = rowsOf(viridis(0));
  const std::vector<int> high = rowsOf(viridis(1));
  ASSERT_FALSE(low.empty());
  ASSERT_FALSE(high.empty());
  EXPECT_GT(low.front(), high.back() + 100) << "high values are on top";
  legend.high = legend.low;  // all values alike: one colour
  const Hud flat = drawHud(state);
  EXPECT_GT(countAll(flat, state, viridis(0.5)), 100);
  EXPECT_EQ(countAll(flat, state, viridis(0)), 0);
}

TEST(Hud, RegionsCoverWhatIsDrawn) {
  HudState state = oneView(1600, 900);
  const Hud plain = drawHud(state);
  // Whatever is opaque belongs to a region.
  for (int y = 0; y < state.height; y += 3) {
    for (int x = 0; x < state.width; x += 3) {
      const bool drawn = pixelAt(plain, state, x, y)[3] > 0;
      EXPECT_EQ(drawn, regionAt(plain, x, y) != nullptr) << x << ", " << y;
    }
  }
  const auto expectCovered = [&](const HudState& more, HudPart part) {
    const Hud hud = drawHud(more);
    ASSERT_NE(regionOf(hud, part), nullptr);
    const auto last =
        std::find_if(hud.regions.rbegin(), hud.regions.rend(), [&](const HudRegion& r) { return r.part == part; });
    EXPECT_TRUE(holds(last->rect, changed(plain, hud, state)));
    EXPECT_FALSE(changed(plain, hud, state).width <= 0);
  };
  HudState help = state;
  help.help = true;
  expectCovered(help, HudPart::Help);
  HudState problem = state;
  problem.problems = {"train-000001.tar: is truncated: copy it again", "train-000002.tar: no such file"};
  expectCovered(problem, HudPart::Problem);
  HudState prompt = state;
  prompt.prompt = "lane";
  prompt.promptCaption = "go to sample:";
  prompt.promptHints = {"lane-000001"};
  expectCovered(prompt, HudPart::Panel);
}

TEST(Hud, TheUppermostRegionCounts) {
  HudState state = oneView(800, 600);
  state.panes[0].legend.entries.assign(60, {"some_class", kRoad, 1, 1});
  state.help = true;
  state.keys.assign(60, {"a key", std::string(60, 'x')});
  const Hud hud = drawHud(state);
  const HudRegion* row = regionOf(hud, HudPart::Legend, 5);
  const auto help = std::find_if(hud.regions.rbegin(), hud.regions.rend(),
                                 [](const HudRegion& r) { return r.part == HudPart::Help; });
  ASSERT_NE(row, nullptr);
  ASSERT_TRUE(help->rect.contains(row->rect.left, row->rect.top)) << "they overlap in this test";
  EXPECT_EQ(regionAt(hud, row->rect.left, row->rect.top)->part, HudPart::Help);
  EXPECT_EQ(regionAt(hud, -1, 5), nullptr);
  EXPECT_EQ(regionAt(hud, 5, 600), nullptr);
}

TEST(Hud, TipsStayOnTheCanvasAndBesideThePointer) {
  for (const auto& [width, height] : {std::pair(800, 600), {1600, 900}}) {
    HudState state = oneView(width, height);
    const Hud plain = drawHud(state);
    for (const int x : {0, width / 2, width - 1}) {
      for (const int y : {0, height / 2, height - 1}) {
        state.tip = HudTip{x, y, "car 4711", kTree, {{"class", "car (6)"}, {"range", "12.34 m"}}};
        const Hud hud = drawHud(state);
        const PixelRect box = changed(plain, hud, state);
        EXPECT_TRUE(holds({0, 0, width, height}, box));
        EXPECT_GT(box.width, 60);
        EXPECT_GT(box.height, 30);
        EXPECT_FALSE(box.contains(x, y)) << "the pointer sees what it points at";
        EXPECT_GT(countIn(hud, state, box, kTree), 40);
        // The whole box: its edge is on all four sides.
        for (const auto& [px, py] :
             {std::pair(box.left, box.top + box.height / 2), {box.left + box.width / 2, box.top}}) {
          EXPECT_EQ(pixelAt(hud, state, px, py)[3], 255);
        }
      }
    }
  }
}

TEST(Hud, TipsCoverNoLegend) {
  HudState state = oneView(1000, 700);
  const Hud plain = drawHud(state);
  const PixelRect legend = regionOf(plain, HudPart::Legend, 1)->rect;
  for (const int below : {-30, 5, 60}) {
    state.tip = HudTip{legend.left - 20, legend.top + below, "car 4711", kTree, {{"range", "12.34 m"}, {"ring", "3"}}};
    const Hud hud = drawHud(state);
    for (std::size_t i = 0; i < 3; ++i) {
      const PixelRect row = regionOf(hud, HudPart::Legend, i)->rect;
      for (int y = row.top; y < row.top + row.height; ++y) {
        for (int x = row.left; x < row.left + row.width; ++x) {
          ASSERT_EQ(pixelAt(hud, state, x, y), pixelAt(plain, state, x, y)) << x << ", " << y;
        }
      }
    }
  }
}

// In the lower left corner; in another one where that holds what was clicked. Opaque, and above strip and bar.
TEST(Hud, WhatWasClickedIsDockedInACorner) {
  for (const std::size_t panes : {1u, 2u, 4u}) {
    HudState state = oneView(1200, 800);
    state.strip = HudStrip{numbered(200, 16), {}, "range image"};
    state.panes.resize(panes, state.panes[0]);
    HudState with = state;
    with.docked = HudTip{0, 0, "car 4711", kTree, std::vector(12, std::pair<std::string, std::string>("x", "1.5 m"))};
    const HudLayout layout = layoutHud(state);
    const auto dockedAt = [&] {
      const Hud plain = drawHud(state);
      const Hud hud = drawHud(with);
      const PixelRect box = changed(plain, hud, state);
      EXPECT_EQ(regionAt(hud, box.left + 1, box.top + 1)->part, HudPart::Panel);
      for (int y = box.top; y < box.top + box.height; ++y) {
        for (int x = box.left; x < box.left + box.width; ++x) EXPECT_EQ(pixelAt(hud, state, x, y)[3], 255);
      }
      EXPECT_TRUE(std::any_of(layout.panes.begin(), layout.panes.end(),
                              [&](const PixelRect& pane) { return holds(pane, box); }));
      return box;
    };
    const PixelRect usual = dockedAt();
    const PixelRect& pane = layout.panes[0];
    EXPECT_LT(usual.left, pane.left + 30);
    EXPECT_GT(usual.top + usual.height, pane.top + pane.height - 30);
    with.docked->keepClear = {{usual.left + 20, usual.top + 20}};
    EXPECT_FALSE(dockedAt().contains(usual.left + 20, usual.top + 20));
    // Messages stand beside it.
    with.docked->keepClear.clear();
    with.notices = {"a message"};
    HudState messages = state;
    messages.notices = with.notices;
    const Hud both = drawHud(with);
    with.notices.clear();
    const PixelRect said = changed(drawHud(with), both, state);
    EXPECT_GT(said.width, 20);
    EXPECT_FALSE(said.contains(usual.left + 5, usual.top + usual.height - 5));
  }
}

TEST(Hud, AWarningRowStandsOut) {
  HudState state = oneView(800, 600);
  state.tip = HudTip{300, 300, "car 4711", kTree, {{"range", "1 m"}, {"its classes", "car 3, tree 1"}}};
  EXPECT_EQ(countAll(drawHud(state), state, kAlarm), 0);
  state.tip->alarm = "its classes";
  EXPECT_GT(countAll(drawHud(state), state, kAlarm), 20);
}

TEST(Hud, LabelsAreMarkedAndStayOnTheCanvas) {
  HudState state = oneView(800, 600);
  state.panes.clear();
  const Hud plain = drawHud(state);
  const Rgb color{255, 0, 255};
  for (const auto& [x, y] : {std::pair(400.0, 300.0), {799.0, 300.0}, {400.0, 20.0}, {5.0, 570.0}}) {
    state.labels = {{x, y, "12.34 m", color, true}};
    const Hud hud = drawHud(state);
    EXPECT_GT(countAll(hud, state, color), 20);
    EXPECT_GT(changed(plain, hud, state).width, 40);
  }
  state.labels = {{-1000, 5, "left", color, true}, {NAN, 5, "nowhere", color, true}, {5, 1e30, "far", color, true}};
  EXPECT_EQ(drawHud(state).pixels, plain.pixels);
}

TEST(Hud, BareIsLabelsAlone) {
  HudState state = oneView(800, 600);
  state.bare = true;
  state.problems = {"a problem"};
  state.help = true;
  const Hud hud = drawHud(state);
  EXPECT_TRUE(hud.regions.empty());
  EXPECT_TRUE(std::all_of(hud.pixels.begin(), hud.pixels.end(), [](const Rgba& p) { return p[3] == 0; }));
  EXPECT_EQ(layoutHud(state).panes.at(0), (PixelRect{0, 0, 800, 600}));
  state.labels = {{400, 300, "here", {255, 0, 255}, true}};
  EXPECT_GT(countAll(drawHud(state), state, {255, 0, 255}), 20);
}

TEST(Hud, ImagesAreDrawnWhereTheirPixelsAreFound) {
  HudState state = oneView(800, 600);
  state.strip = HudStrip{numbered(200, 16), {}, "range image"};
  const auto expectDrawn = [&](const PixelRect& rect, const Image& image, HudPart part) {
    const Hud hud = drawHud(state);
    ASSERT_NE(regionOf(hud, part), nullptr);
    EXPECT_EQ(regionOf(hud, part)->rect, rect);
    std::vector<bool> seen(image.pixels.size());
    for (int y = rect.top; y < rect.top + rect.height; ++y) {
      for (int x = rect.left; x < rect.left + rect.width; ++x) {
        const auto at = imagePixelAt(rect, image, x, y);
        ASSERT_TRUE(at);
        const Rgb& color = image.at(at->first, at->second);
        ASSERT_EQ(pixelAt(hud, state, x, y), (Rgba{color[0], color[1], color[2], 255}));
        seen[static_cast<std::size_t>(at->second * image.width + at->first)] = true;
      }
    }
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](bool s) { return s; }));
    EXPECT_FALSE(imagePixelAt(rect, image, rect.left - 1, rect.top));
    EXPECT_FALSE(imagePixelAt(rect, image, rect.left, rect.top + rect.height));
  };
  expectDrawn(layoutHud(state).strip, state.strip->image, HudPart::Strip);
  state.strip.reset();
  state.panes.clear();  // their legends lie over the picture
  state.picture = HudStrip{numbered(100, 60), {}, "semantic"};
  const PixelRect rect = layoutHud(state).picture;
  EXPECT_EQ(rect.width % 100, 0);
  EXPECT_EQ(rect.width * 60, rect.height * 100);
  expectDrawn(rect, state.picture->image, HudPart::Picture);
  state.picture->mark = std::pair(50, 30);
  EXPECT_NE(drawHud(state).pixels, [&] {
    HudState unmarked = state;
    unmarked.picture->mark.reset();
    return drawHud(unmarked).pixels;
  }());
}

// A letter of any script is one mark; nothing breaks inside of it.
TEST(Hud, TextsMayHoldAnyBytes) {
  HudState state = oneView(800, 600);
  const std::string words =
      "Stra\xc3\x9f"
      "e \xe9\x81\x93\xe8\xb7\xaf \xf0\x9f\x9a\x97";
  const std::string broken = "\xff\xfe\x80\x80 \xc3";
  state.title = state.key = state.busy = state.promptCaption = words;
  state.summary = broken;
  state.problems = {words, broken, std::string(5000, '\x80'), std::string(5000, 'x')};
  state.notices = {words + "\n" + broken};
  state.prompt = words + broken;
  state.promptHints = {words, broken};
  state.tip = HudTip{10, 10, words, kCar, {{broken, words}, {words, broken}}};
  state.labels = {{300, 300, words, kCar, true}};
  state.panes[0].legend.entries[0].name = words;
  EXPECT_EQ(drawHud(state).pixels, drawHud(state).pixels);
  HudState marks = oneView(800, 600);
  HudState other = marks;
  marks.key = "\xe9\x81\x93";
  other.key = "?";
  EXPECT_EQ(drawHud(marks).pixels, drawHud(other).pixels);
}

TEST(Hud, SurvivesEverything) {
  std::mt19937 random(20240607);
  const auto upTo = [&](std::size_t most) { return static_cast<std::size_t>(random() % (most + 1)); };
  const auto words = [&](std::size_t most) {
    std::string text(upTo(most), ' ');
    for (char& c : text) c = static_cast<char>(random() % 4 == 0 ? ' ' : random() % 256);
    return text;
  };
  const auto image = [&] { return numbered(static_cast<int>(upTo(300)), static_cast<int>(upTo(80))); };
  for (int round = 0; round < 150; ++round) {
    HudState state;
    state.width = 64 + static_cast<int>(upTo(round % 10 == 0 ? 1500 : 300));
    state.height = 64 + static_cast<int>(upTo(round % 10 == 0 ? 900 : 300));
    state.title = words(200);
    state.summary = words(60);
    state.panes.resize(upTo(8));
    for (HudPane& pane : state.panes) {
      pane.caption = words(30);
      pane.clickable = upTo(1) == 1;
      pane.legend.title = words(60);
      pane.legend.scale = upTo(2) == 0;
      pane.legend.low = upTo(3) == 0 ? NAN : static_cast<double>(upTo(1000)) - 500;
      pane.legend.high = upTo(3) == 0 ? INFINITY : static_cast<double>(upTo(100000));
      pane.legend.power = static_cast<double>(upTo(3));
      for (std::size_t i = upTo(100); i > 0; --i) pane.legend.entries.push_back({words(40), kRoad, 1, random()});
      for (std::size_t i = upTo(120); i > 0; --i) pane.hidden.push_back(upTo(1) == 1);
    }
    if (upTo(3) > 0) state.frame = upTo(70);
    state.frames = upTo(60);
    state.key = words(60);
    state.playing = upTo(1) == 1;
    if (upTo(1) == 1) state.strip = HudStrip{image(), std::pair<int, int>(upTo(400), upTo(90)), words(60)};
    if (upTo(3) == 0) state.picture = HudStrip{image(), std::pair<int, int>(upTo(400), upTo(90)), words(60)};
    state.busy = words(60);
    for (std::size_t i = upTo(6); i > 0; --i) state.problems.push_back(words(400));
    for (std::size_t i = upTo(4); i > 0; --i) state.notices.push_back(words(90));
    if (upTo(1) == 1) state.prompt = words(100);
    state.promptCaption = words(30);
    for (std::size_t i = upTo(20); i > 0; --i) state.promptHints.push_back(words(50));
    for (std::size_t i = upTo(5); i > 0; --i) {
      state.labels.push_back(
          {static_cast<double>(upTo(500)) - 50, static_cast<double>(upTo(500)) - 50, words(40), kCar, true});
    }
    if (upTo(1) == 1) {
      state.tip = HudTip{static_cast<int>(upTo(600)) - 100, static_cast<int>(upTo(600)) - 100, words(50), kCar, {}};
      for (std::size_t i = upTo(30); i > 0; --i) state.tip->rows.emplace_back(words(20), words(80));
    }
    if (upTo(1) == 1) {
      state.docked = HudTip{0, 0, words(50), kCar, {}, "", upTo(9), {}};
      for (std::size_t i = upTo(60); i > 0; --i) state.docked->rows.emplace_back(words(20), words(80));
      for (std::size_t i = upTo(4); i > 0; --i) state.docked->keepClear.emplace_back(upTo(500), upTo(300));
    }
    state.help = upTo(2) == 0;
    for (std::size_t i = upTo(40); i > 0; --i) state.keys.emplace_back(words(15), words(50));
    state.bare = upTo(9) == 0;
    const Hud hud = drawHud(state);
    ASSERT_EQ(hud.pixels.size(), static_cast<std::size_t>(state.width) * static_cast<std::size_t>(state.height));
    const HudLayout layout = layoutHud(state);
    ASSERT_EQ(layout.panes.size(), state.panes.size());
    const PixelRect canvas{0, 0, state.width, state.height};
    for (const PixelRect& pane : layout.panes) {
      EXPECT_TRUE(holds(canvas, pane));
      EXPECT_GT(pane.width, 0);
      EXPECT_GT(pane.height, 0);
    }
    EXPECT_TRUE(holds(canvas, layout.strip));
    EXPECT_TRUE(holds(canvas, layout.picture));
    for (const HudRegion& region : hud.regions) {
      if (region.part == HudPart::Legend) {
        EXPECT_LT(region.entry, state.panes.at(region.pane).legend.entries.size());
      }
      if (region.part == HudPart::Slider && state.frames > 0) {
        EXPECT_LT(sliderFrame(region.rect, state.frames, region.rect.left + region.rect.width), state.frames);
      }
    }
  }
}

}  // namespace
}  // namespace scanmill
