#include "town/geometry.h"

namespace scanmill::town {
namespace {

const Polygon kSquare{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
const Polygon kHole{{4, 4}, {4, 6}, {6, 6}, {6, 4}};

TEST(Polygons, InsideAndDistanceOfASquareWithAHole) {
  const std::vector<const Polygon*> rings{&kSquare, &kHole};
  EXPECT_TRUE(isInside(rings, {1, 5}));
  EXPECT_FALSE(isInside(rings, {5, 5}));
  EXPECT_FALSE(isInside(rings, {11, 5}));
  EXPECT_NEAR(distanceToRings(rings, {5, 5}), 1, 1e-12);
  EXPECT_NEAR(distanceToRings(rings, {13, 14}), 5, 1e-12);
  EXPECT_NEAR(areaOf(kSquare), 100, 1e-12);
  EXPECT_NEAR(areaOf(kHole), -4, 1e-12);
}

// Whatever the turn, a rectangle is its own, and that of an L is the rectangle it was cut from.
TEST(Polygons, TheSmallestRectangle) {
  for (const double yaw : {0.0, 0.3, 1.2, 2.9}) {
    const auto turned = [&](double x, double y) {
      return Point2{7 + x * std::cos(yaw) - y * std::sin(yaw), -3 + x * std::sin(yaw) + y * std::cos(yaw)};
    };
    const Polygon shape{turned(-6, -2), turned(6, -2), turned(6, 2), turned(1, 2), turned(1, 1), turned(-6, 1)};
    const models::Footprint f = rectangleAbout(shape);
    EXPECT_NEAR(4 * f.halfX * f.halfY, 48, 1e-9);
    EXPECT_NEAR(f.center.x, 7, 1e-9);
    EXPECT_NEAR(f.center.y, -3, 1e-9);
  }
}

// What is inside of both, and no more: by the sizes of an L that a square cuts, whichever corner it lies at.
TEST(Polygons, AreClippedToASquare) {
  for (const double sx : {1.0, -1.0}) {
    for (const double sy : {1.0, -1.0}) {
      Polygon l{{0, 0}, {30, 0}, {30, 5}, {5, 5}, {5, 30}, {0, 30}};
      for (Point2& p : l) p = {sx * (p.x - 2), sy * (p.y - 3)};
      if (sx * sy < 0) std::reverse(l.begin(), l.end());
      EXPECT_NEAR(areaOf(clipped(l, 10)), 12 * 5 + 5 * (13 - 5), 1e-9);
      EXPECT_NEAR(areaOf(clipped(l, 100)), areaOf(l), 1e-9);
    }
  }
  EXPECT_TRUE(clipped({{50, 50}, {60, 50}, {60, 60}}, 10).empty());
  EXPECT_NEAR(areaOf(clipped({{-50, -50}, {50, -50}, {50, 50}, {-50, 50}}, 10)), 400, 1e-9) << "all of the square";
}

TEST(Lines, RoundsCornersAndKeepsEnds) {
  const std::vector<Point2> corner = smoothLine({{0, 0}, {40, 0}, {40, 60}}, 2);
  EXPECT_EQ(corner.front().x, 0);
  EXPECT_EQ(corner.back().y, 60);
  double cut = 1e9;
  for (std::size_t i = 0; i < corner.size(); ++i) {
    cut = std::min(cut, std::hypot(corner[i].x - 40, corner[i].y));
    if (i == 0) continue;
    EXPECT_LT(std::hypot(corner[i].x - corner[i - 1].x, corner[i].y - corner[i - 1].y), 2.1);
  }
  EXPECT_GT(cut, 0.7);
  EXPECT_LT(cut, 2.5);
  for (const Point2& p : smoothLine({{0, 0}, {10, 5}, {100, 50}}, 2)) EXPECT_NEAR(p.y, p.x / 2, 1e-9);
}

TEST(Lines, DenseLinesKeepTheirCorners) {
  const Line dense = denseLine({{0, 0}, {0, 0.01}, {5, 0}, {5, 0}, {5, 3.3}, {0, 0}}, 2);
  EXPECT_NEAR(lengthOf(dense), lengthOf({{0, 0}, {5, 0}, {5, 3.3}, {0, 0}}), 1e-9);
  for (std::size_t i = 1; i < dense.size(); ++i) {
    EXPECT_GT(distance(dense[i - 1], dense[i]), 1);
    EXPECT_LT(distance(dense[i - 1], dense[i]), 3);
  }
}

TEST(Lines, RunsWithinASquareHaveNoGaps) {
  const Line line = evenLine({{-30, 0}, {30, 0}, {30, 5}, {-30, 5}}, 1);
  const std::vector<Line> runs = runsWithin(line, 10);
  ASSERT_EQ(runs.size(), 2u);
  for (const Line& run : runs) EXPECT_NEAR(lengthOf(run), 19, 1.1);
  EXPECT_NEAR(nearestOn(line, {-3, 4}).distance, 1, 1e-9);
  EXPECT_NEAR(nearestOn(line, {-3, 4}).along, 60 + 5 + 33, 1e-9);
  EXPECT_NEAR(pointAt(line, 62).x, 30, 1e-9);
}

}  // namespace
}  // namespace scanmill::town
