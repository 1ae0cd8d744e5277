#include "viewer/splats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"
#include "viewer/color_map.h"

namespace scanmill {

namespace {

constexpr Rgb kRed{255, 0, 0};
constexpr Rgb kBlue{0, 0, 255};
constexpr int kWidth = 320;
constexpr int kHeight = 180;

Image drawn(const std::vector<Vec3f>& points, const std::vector<Rgb>& colors, View view = View::Driver,
            bool depthEdges = false, double size = 1) {
  SplatStyle style;
  style.depthEdges = depthEdges;
  style.size = size;
  return drawSplats(points, colors, makeCamera(view, kWidth, kHeight, 1), kWidth, kHeight, style);
}

std::ptrdiff_t painted(const Image& image) {
  return std::count_if(image.pixels.begin(), image.pixels.end(), [](const Rgb& p) { return p != kBackground; });
}

TEST(Splats, LandWhereTheCameraProjectsThem) {
  for (const View view : {View::Driver, View::Above, View::Chase}) {
    const ViewCamera camera = makeCamera(view, kWidth, kHeight, 1);
    for (const Vec3f point : {Vec3f{12, 3, -1}, Vec3f{9, -4, -2}, Vec3f{10, 0.5f, 1}}) {
      const Image image = drawn({point}, {kRed}, view, false, 3);
      const Projected p = camera.project(Vec3d(point));
      ASSERT_TRUE(image.contains(static_cast<int>(p.x), static_cast<int>(p.y)));
      EXPECT_EQ(image.at(static_cast<int>(p.x), static_cast<int>(p.y)), kRed);
      double sumX = 0, sumY = 0, sum = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const double weight = image.at(x, y)[0] - kBackground[0];
          sumX += weight * (x + 0.5);
          sumY += weight * (y + 0.5);
          sum += weight;
        }
      }
      EXPECT_NEAR(sumX / sum, p.x, 0.3) << "the middle of the splat";
      EXPECT_NEAR(sumY / sum, p.y, 0.3);
    }
  }
}

TEST(Splats, NearerWinsInAnyOrder) {
  const Vec3f near{5, 0, 0};
  const Vec3f far{20, 0, 0};
  EXPECT_EQ(drawn({near, far}, {kRed, kBlue}).at(kWidth / 2, kHeight / 2), kRed);
  EXPECT_EQ(drawn({far, near}, {kBlue, kRed}).at(kWidth / 2, kHeight / 2), kRed);
  const Image above = drawn({{3, 0, -2}, {3, 0, 5}}, {kBlue, kRed}, View::Above, false, 4);
  const Projected p = makeCamera(View::Above, kWidth, kHeight, 1).project({3, 0, 5});
  EXPECT_EQ(above.at(static_cast<int>(p.x), static_cast<int>(p.y)), kRed) << "the higher point";
}

TEST(Splats, FirstWinsAtEqualDepth) {
  EXPECT_EQ(drawn({{5, 0, 0}, {5, 0, 0}}, {kRed, kBlue}).at(kWidth / 2, kHeight / 2), kRed);
}

TEST(Splats, ShrinkWithDistanceAndGrowWithSize) {
  const auto pixelsAt = [](float x, double size) {
    return painted(drawn({{x, 0, 0}}, {kRed}, View::Driver, false, size));
  };
  EXPECT_GT(pixelsAt(1, 4), pixelsAt(3, 4));
  EXPECT_GT(pixelsAt(3, 4), pixelsAt(60, 4));
  EXPECT_GT(pixelsAt(60, 1), 0) << "never vanishes";
  EXPECT_NEAR(static_cast<double>(pixelsAt(1, 8)) / static_cast<double>(pixelsAt(1, 4)), 4, 0.8);
}

TEST(Splats, LeavesOutWhatCannotBeSeen) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<Vec3f> unseen{{-5, 0, 0},    {0.1f, 0, 0},     {kNaN, kNaN, kNaN}, {kInfinity, 0, 0},
                                  {5, 1e30f, 0}, {5, 0, -1000.0f}, {0, 0, 0},          {3e38f, 3e38f, 3e38f}};
  EXPECT_EQ(painted(drawn(unseen, std::vector<Rgb>(unseen.size(), kRed))), 0);
  EXPECT_EQ(painted(drawn({}, {})), 0);
}

// A near pole in front of a far wall: the wall darkens beside the pole, and only there.
TEST(Splats, DepthEdgesDarkenTheFartherSide) {
  std::vector<Vec3f> points;
  for (int y = -200; y <= 200; ++y) {
    for (int z = -120; z <= 120; ++z)
      points.push_back({20, static_cast<float>(y) * 0.05f, static_cast<float>(z) * 0.05f});
  }
  for (int z = -200; z <= 200; ++z) points.push_back({8, 0, static_cast<float>(z) * 0.02f});
  const std::vector<Rgb> colors(points.size(), kRed);
  const Image flat = drawn(points, colors, View::Driver, false, 2);
  const Image shaded = drawn(points, colors, View::Driver, true, 2);
  const int row = kHeight / 2;
  EXPECT_EQ(flat.at(kWidth / 2 - 40, row), kRed);
  EXPECT_EQ(shaded.at(kWidth / 2 - 40, row), kRed);
  EXPECT_EQ(shaded.at(kWidth / 2, row), kRed) << "the pole itself";
  int darkest = 255;
  for (int x = kWidth / 2 - 12; x < kWidth / 2 + 12; ++x) darkest = std::min<int>(darkest, shaded.at(x, row)[0]);
  EXPECT_LT(darkest, 160);
}

TEST(Splats, TheSameEveryTime) {
  std::vector<Vec3f> points;
  std::vector<Rgb> colors;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const RandomBlock r = randomBlock({.beam = i});
    points.push_back({static_cast<float>(uniform(r[0]) * 40), static_cast<float>(uniform(r[1]) * 40 - 20),
                      static_cast<float>(uniform(r[2]) * 6 - 3)});
    colors.push_back(viridis(uniform(r[3])));
  }
  EXPECT_EQ(drawn(points, colors, View::Chase, true).pixels, drawn(points, colors, View::Chase, true).pixels);
}

}  // namespace

}  // namespace scanmill
