#include "viewer/contact_sheet.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "scenefile/scene_file.h"
#include "tests/studio/viewer/window/fake_frames.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

// Absent where this machine has no OpenGL.
std::optional<Image> sheetOf(const std::string& objects) {
  const TemporaryFolder folder;
  const Scene scene = readScene(folder.write("s.yaml", kSceneHead + objects), {});
  try {
    return drawContactSheet(scene);
  } catch (const Error& e) {
    if (std::string(e.what()).find("no OpenGL") == std::string::npos) throw;
    return std::nullopt;
  }
}

std::string box(const std::string& name, const std::string& className, double size, const std::string& more = "") {
  return fmt::format("  - {{name: {0}, primitive: box, size: [{1}, {2}, {2}], class: {3}, material: wood{4}}}\n", name,
                     size, size / 2, className, more);
}

struct Extent {
  int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1;
  int pixels = 0;
  int height() const { return bottom - top + 1; }
};

// Of the pixels in a cell whose hue is that of the colour, whatever the light: the brightest channels are as bright
// among each other.
Extent extentOf(const Image& image, int cell, int columns, int width, const Rgb& color) {
  const int height = width * 2 / 3;
  const int x0 = cell % columns * (width + 2);
  const int y0 = 34 + cell / columns * (height + 66 + 2);
  Extent e;
  const double most = *std::ranges::max_element(color);
  for (int y = y0; y < y0 + height; ++y) {
    for (int x = x0; x < x0 + width; ++x) {
      const Rgb& p = image.at(x, y);
      const double own = *std::ranges::max_element(p);
      if (own < 60) continue;
      bool same = true;
      for (std::size_t c = 0; c < 3; ++c) same = same && std::abs(p[c] / own - color[c] / most) < 0.06;
      if (!same) continue;
      e.left = std::min(e.left, x - x0);
      e.right = std::max(e.right, x - x0);
      e.top = std::min(e.top, y - y0);
      e.bottom = std::max(e.bottom, y - y0);
      ++e.pixels;
    }
  }
  return e;
}

constexpr Rgb kYellow{250, 220, 60};
constexpr Rgb kCar{40, 90, 255};
constexpr Rgb kTree{0, 190, 60};

TEST(ContactSheet, HasACellForEachObjectInItsColour) {
  const auto image = sheetOf(box("a", "car", 4) + box("b", "tree", 8,
                                                      ", copies: {grid: {count: [5, 1, 1], spacing: [9, 9, "
                                                      "9]}}, yaw_deg: 40, position: [800, 0, 3]"));
  if (!image) GTEST_SKIP() << "this machine has no OpenGL by EGL";
  EXPECT_EQ(image->width, 2 * 642 - 2);
  EXPECT_GT(extentOf(*image, 0, 2, 640, kCar).pixels, 3000);
  EXPECT_EQ(extentOf(*image, 0, 2, 640, kTree).pixels, 0);
  EXPECT_GT(extentOf(*image, 1, 2, 640, kTree).pixels, 3000) << "one copy of five, wherever it stands";
  EXPECT_EQ(extentOf(*image, 1, 2, 640, kCar).pixels, 0);
}

// The block of 1.8 m tells the scale: beside a bus of 12 cm it is a tower, beside one of 12 m low.
TEST(ContactSheet, APersonTellsTheScale) {
  const auto image = sheetOf(box("toy", "car", 0.12) + box("car", "car", 4) + box("giant", "car", 40));
  if (!image) GTEST_SKIP() << "this machine has no OpenGL by EGL";
  std::vector<double> ratio;
  for (int cell = 0; cell < 3; ++cell) {
    const Extent car = extentOf(*image, cell, 2, 640, kCar);
    const Extent person = extentOf(*image, cell, 2, 640, kYellow);
    ASSERT_GT(person.pixels, 0) << cell;
    ratio.push_back(static_cast<double>(person.height()) / std::max(car.height(), 1));
  }
  EXPECT_GT(ratio[0], 8);
  EXPECT_GT(ratio[1], 0.5);
  EXPECT_LT(ratio[1], 1.5);
  EXPECT_LT(ratio[2], 0.25);
}

// The front, +x, is left of the middle, towards the viewer, whatever the heading in the scene.
TEST(ContactSheet, LooksAtTheFront) {
  for (const char* const turn : {"", ", yaw_deg: 90", ", yaw_deg: 200"}) {
    const auto image = sheetOf(box("car", "car", 4, turn));
    if (!image) GTEST_SKIP() << "this machine has no OpenGL by EGL";
    const Extent arrow = extentOf(*image, 0, 1, 960, {255, 70, 60});
    const Extent car = extentOf(*image, 0, 1, 960, kCar);
    ASSERT_GT(arrow.pixels, 20);
    EXPECT_LT(arrow.left + arrow.right, car.left + car.right) << turn;
    EXPECT_GT(arrow.bottom, (car.top + car.bottom) / 2) << turn;
  }
}

TEST(ContactSheet, OfManyObjectsHasSomeOfEachSeries) {
  std::string objects;
  for (int i = 0; i < 80; ++i) objects += box(fmt::format("car_{}", i), "car", 4);
  objects += box("one", "tree", 3);
  const auto image = sheetOf(objects);
  if (!image) GTEST_SKIP() << "this machine has no OpenGL by EGL";
  EXPECT_EQ(image->width, 5 * 322 - 2);
  EXPECT_EQ(image->height, 34 + 12 * (213 + 68)) << "sixty cells";
  EXPECT_GT(extentOf(*image, 59, 5, 320, kTree).pixels, 300) << "the last of all";
  EXPECT_GT(extentOf(*image, 58, 5, 320, kCar).pixels, 300);
}

// Whatever objects are called, each has its cell.
TEST(ContactSheet, NamesDoNotJoinObjects) {
  const auto image = sheetOf(box("cars/a", "car", 4) + box("cars/b", "tree", 4) + box("'bus #2'", "car", 4) +
                             box("'bus #3'", "tree", 4));
  if (!image) GTEST_SKIP() << "this machine has no OpenGL by EGL";
  EXPECT_EQ(image->width, 2 * 642 - 2);
  for (int cell = 0; cell < 4; ++cell) {
    EXPECT_EQ(extentOf(*image, cell, 2, 640, kCar).pixels > 1000, cell % 2 == 0) << cell;
    EXPECT_EQ(extentOf(*image, cell, 2, 640, kTree).pixels > 1000, cell % 2 == 1) << cell;
  }
}

}  // namespace
}  // namespace scanmill
