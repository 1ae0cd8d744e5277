#include "viewer/font.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace scanmill {

namespace {

constexpr Rgb kBlack{0, 0, 0};
constexpr Rgb kWhite{255, 255, 255};

Image written(std::string_view text, double cell = 2) {
  Image image(120, 40, kBlack);
  drawText(image, 6, 6, text, kWhite, cell);
  return image;
}

TEST(Font, EveryLetterDiffers) {
  std::map<std::vector<Rgb>, char> seen;
  for (char c = ' '; c <= '~'; ++c) {
    if (c == 'O') continue;  // the same as a zero
    const auto [at, fresh] = seen.emplace(written(std::string(1, c)).pixels, c);
    EXPECT_TRUE(fresh) << "'" << c << "' looks like '" << at->second << "'";
  }
}

TEST(Font, WidthIsWhatIsDrawn) {
  for (const std::string text : {"W", "truck_town", "ill", "12.5"}) {
    const Image image = written(text, 1.5);
    int left = image.width;
    int right = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        if (image.at(x, y)[0] < 100) continue;
        left = std::min(left, x);
        right = std::max(right, x + 1);
      }
    }
    EXPECT_NEAR(left, 6, 1.01) << text;
    EXPECT_NEAR(right - left, textWidth(text, 1.5), 2.01) << text;
  }
}

TEST(Font, StrangeLettersAreQuestionMarks) {
  EXPECT_EQ(written("\xC3\xA9").pixels, written("?").pixels) << "one for a UTF-8 sequence";
  EXPECT_EQ(written("a\tb").pixels, written("a?b").pixels);
}

TEST(Font, FitsByCutting) {
  const std::string text = "a_rather_long_class_name";
  EXPECT_EQ(fitText(text, 1000, 2), text);
  const std::string cut = fitText(text, 80, 2);
  EXPECT_LE(textWidth(cut, 2), 80);
  EXPECT_TRUE(cut.ends_with("...") && text.starts_with(cut.substr(0, cut.size() - 3)));
  EXPECT_EQ(fitText(text, 1, 2), "");
}

TEST(Font, StaysInTheImage) {
  Image image(10, 10, kBlack);
  drawText(image, -30, -5, "all over the place", kWhite, 3);
  drawText(image, 8, 8, "W", kWhite, 3);
  EXPECT_EQ(image.pixels.size(), 100u);
}

}  // namespace

}  // namespace scanmill
