#include "viewer/window/hud_paint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "viewer/font.h"

namespace scanmill {
namespace {

// The program's letters, wherever they stand on whole pixels.
TEST(HudPaint, LettersAreThoseOfPictures) {
  const Rgb under{10, 60, 90};
  const Rgb color{250, 200, 30};
  for (const double cell : {1.0, 1.6, 3.0}) {
    for (const char c : {'A', 'g', '~', '1'}) {
      Image drawn(60, 60, under);
      drawText(drawn, 8, 9, std::string(1, c), color, cell);
      HudPaint paint(60, 60);
      paint.fill({0, 0, 60, 60}, opaque(under));
      paint.text(8, 9, std::string(1, c), color, cell);
      const std::vector<Rgba> pixels = paint.take();
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(pixels[i][k], drawn.pixels[i][k], 1) << c << " at " << i;
      }
    }
  }
}

TEST(HudPaint, OpacitiesAddUpAsLayersOfGlass) {
  HudPaint paint(4, 1);
  paint.fill({0, 0, 1, 1}, {200, 0, 0, 128});
  paint.fill({1, 0, 1, 1}, {200, 0, 0, 128});
  paint.fill({1, 0, 1, 1}, {0, 200, 0, 128});
  paint.fill({2, 0, 1, 1}, {200, 0, 0, 255});
  paint.fill({2, 0, 1, 1}, {0, 200, 0, 128});
  const std::vector<Rgba> pixels = paint.take();
  EXPECT_EQ(pixels[0], (Rgba{200, 0, 0, 128}));
  const double a = 128 / 255.0;
  EXPECT_NEAR(pixels[1][3], 255 * (a + a * (1 - a)), 1);
  EXPECT_NEAR(pixels[1][1], 200 * a / (a + a * (1 - a)), 1);
  EXPECT_EQ(pixels[2][3], 255);
  EXPECT_NEAR(pixels[2][0], 200 * (1 - a), 1);
  EXPECT_NEAR(pixels[2][1], 200 * a, 1);
  EXPECT_EQ(pixels[3], (Rgba{}));
}

TEST(HudPaint, DiscsHaveTheirArea) {
  for (const double radius : {2.0, 5.5, 20.0}) {
    HudPaint paint(64, 64);
    paint.disc(31.3, 32.7, radius, kText);
    double area = 0;
    for (const Rgba& p : paint.take()) area += p[3] / 255.0;
    EXPECT_NEAR(area, M_PI * radius * radius, 0.03 * M_PI * radius * radius + 0.5);
  }
}

TEST(HudPaint, WhatJutsOutIsLeftOut) {
  HudPaint paint(8, 8);
  paint.fill({-100, -100, 90, 90}, opaque(kText));
  paint.frame({-5, -5, 3, 3}, opaque(kText), 9);
  paint.disc(-40, 3, 6, kText);
  paint.image({9, 9, 5, 5}, Image(2, 2, kText));
  paint.text(-300, 2, "left", kText, 1);
  paint.text(2, 300, "below", kText, 1);
  paint.arrow({20, 20, 0, 0}, kText);
  for (const Rgba& p : paint.take()) EXPECT_EQ(p, (Rgba{}));
}

TEST(HudPaint, LinesBreakWhereTheyShould) {
  const double cell = 1;
  const std::string text = "train-000001.tar is truncated: copy the shard again";
  for (const double width : {30.0, 60.0, 100.0, 1000.0}) {
    const std::vector<std::string> lines = wrappedText(text, width, cell, 100);
    std::string joined;
    for (const std::string& line : lines) {
      EXPECT_LE(textWidth(line, cell), width);
      joined += line;
    }
    std::string letters = text;
    std::erase(letters, ' ');
    std::erase(joined, ' ');
    EXPECT_EQ(joined, letters) << "nothing is lost";
  }
  EXPECT_EQ(wrappedText("a\nb", 100, cell, 9), (std::vector<std::string>{"a", "b"}));
  const std::vector<std::string> cut = wrappedText(text, 60, cell, 2);
  ASSERT_EQ(cut.size(), 2u);
  EXPECT_TRUE(cut[1].ends_with("..."));
  EXPECT_LE(textWidth(cut[1], cell), 60.5);
  EXPECT_EQ(fittedText(text, textWidth(text, cell), cell), text);
  EXPECT_EQ(fittedTail(text, textWidth(text, cell), cell), text);
  const std::string tail = fittedTail(text, 60, cell);
  EXPECT_TRUE(tail.starts_with("..."));
  EXPECT_TRUE(tail.ends_with("again"));
  EXPECT_LE(textWidth(tail, cell), 60);
}

}  // namespace
}  // namespace scanmill
