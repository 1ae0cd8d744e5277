#include "scene/town/areas.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/town/layout.h"

namespace scanmill::town {
namespace {

const Polygon kSquare{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
const Polygon kHole{{4, 4}, {4, 6}, {6, 6}, {6, 4}};

TEST(Areas, InsideAndDistanceOfASquareWithAHole) {
  const std::vector<const Polygon*> rings{&kSquare, &kHole};
  EXPECT_TRUE(isInside(rings, {1, 5}));
  EXPECT_FALSE(isInside(rings, {5, 5}));
  EXPECT_FALSE(isInside(rings, {11, 5}));
  EXPECT_NEAR(distanceToRings(rings, {5, 5}), 1, 1e-12);
  EXPECT_NEAR(distanceToRings(rings, {13, 14}), 5, 1e-12);
  EXPECT_NEAR(sizeOf(kSquare), 100, 1e-12);
  EXPECT_NEAR(sizeOf(kHole), -4, 1e-12);
}

TEST(Areas, TheSmallestAreaIsTold) {
  Areas areas;
  areas.add({Land::Grass, {{-100, -100}, {100, -100}, {100, 100}, {-100, 100}}, {}});
  areas.add({Land::Water, kSquare, {kHole}});
  EXPECT_EQ(areas.at({50, 50}), Land::Grass);
  EXPECT_EQ(areas.at({2, 2}), Land::Water);
  EXPECT_EQ(areas.at({5, 5}), Land::Grass) << "an island";
  EXPECT_EQ(areas.at({500, 0}), std::nullopt);
  EXPECT_NEAR(areas.outsideHard({2, 5}), -2, 1e-12);
  EXPECT_NEAR(areas.outsideHard({13, 5}), 3, 1e-12);
  EXPECT_NEAR(areas.outsideHard({5, 5}), 1, 1e-12);
  EXPECT_EQ(areas.outsideHard({60, 60}), Areas::kReach);
}

// Whatever the turn, a rectangle is its own, and that of an L is the rectangle it was cut from.
TEST(Areas, TheSmallestRectangle) {
  for (const double yaw : {0.0, 0.3, 1.2, 2.9}) {
    const auto turned = [&](double x, double y) {
      return Point2{7 + x * std::cos(yaw) - y * std::sin(yaw), -3 + x * std::sin(yaw) + y * std::cos(yaw)};
    };
    const Polygon shape{turned(-6, -2), turned(6, -2), turned(6, 2), turned(1, 2), turned(1, 1), turned(-6, 1)};
    const parts::Footprint f = rectangleAbout(shape);
    EXPECT_NEAR(4 * f.halfX * f.halfY, 48, 1e-9);
    EXPECT_NEAR(f.center.x, 7, 1e-9);
    EXPECT_NEAR(f.center.y, -3, 1e-9);
  }
}

}  // namespace
}  // namespace scanmill::town
