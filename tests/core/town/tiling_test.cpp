#include "town/tiling.h"

#include <map>
#include <utility>

namespace scanmill::town {
namespace {

double areaOf(const Tiling& t, const std::array<std::uint32_t, 3>& corners) {
  const Point2& a = t.points[corners[0]];
  const Point2& b = t.points[corners[1]];
  const Point2& c = t.points[corners[2]];
  return ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
}

double areaOf(const Tiling& t) {
  double area = 0;
  for (const auto& corners : t.triangles) area += areaOf(t, corners);
  return area;
}

// Every edge is that of two triangles which go along it in opposite directions, or lies on the border.
void expectClosed(const Tiling& t, double half) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& corners : t.triangles) {
    EXPECT_GT(areaOf(t, corners), 0);
    for (std::size_t i = 0; i < 3; ++i) ++edges[{corners[i], corners[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    if (edges.contains({edge.second, edge.first})) continue;
    const Point2& a = t.points[edge.first];
    const Point2& b = t.points[edge.second];
    const bool onX = a.x == b.x && std::abs(a.x) == half;
    const bool onY = a.y == b.y && std::abs(a.y) == half;
    ASSERT_TRUE(onX || onY) << a.x << ' ' << a.y << " to " << b.x << ' ' << b.y;
  }
}

// Small cells around a point off the middle, next to large ones.
Tiling fineAt(double x0, double y0) {
  return makeTiling(
      32, 0.5, [=](double x, double y, double size) { return std::hypot(x - x0, y - y0) - size < 4 && size > 0.5; });
}

TEST(Tiling, CoversTheSquareOnce) {
  const Tiling coarse = makeTiling(32, 0.5, [](double, double, double) { return false; });
  EXPECT_EQ(coarse.triangles.size(), 2u);
  for (const Tiling& t : {coarse, fineAt(5.3, -11.2), fineAt(-31, 31)}) {
    EXPECT_NEAR(areaOf(t), 64.0 * 64.0, 1e-9);
    expectClosed(t, 32);
  }
  EXPECT_GT(fineAt(5.3, -11.2).triangles.size(), 300u);
}

TEST(Tiling, CellsAreNoSmallerThanAsked) {
  const Tiling t = makeTiling(8, 0.5, [](double, double, double) { return true; });
  EXPECT_EQ(t.triangles.size(), 2u * 32 * 32);
}

template <class Field>
void cutAlong(Tiling& t, const Field& field) {
  std::vector<double> values;
  for (std::uint32_t p = 0; p < t.points.size(); ++p) values.push_back(field(p));
  town::cutAlong(t, std::move(values));
}

// Along circles and lines at once, whatever goes through corners: no triangle has corners on both sides.
TEST(Tiling, IsCutAlongLines) {
  Tiling t = fineAt(3, 2);
  const auto circle = [&](std::uint32_t p) { return std::hypot(t.points[p].x - 3, t.points[p].y - 2) - 7.3; };
  const auto slanted = [&](std::uint32_t p) { return t.points[p].x - 0.37 * t.points[p].y - 1; };
  const auto straight = [&](std::uint32_t p) { return t.points[p].y - 2; };
  cutAlong(t, circle);
  cutAlong(t, slanted);
  cutAlong(t, straight);
  EXPECT_NEAR(areaOf(t), 64.0 * 64.0, 1e-9);
  expectClosed(t, 32);
  const auto expectOneSided = [&](const auto& field, double tolerance) {
    for (const auto& corners : t.triangles) {
      double low = 1e9;
      double high = -1e9;
      for (const std::uint32_t p : corners) {
        low = std::min(low, field(p));
        high = std::max(high, field(p));
      }
      EXPECT_TRUE(low > -tolerance || high < tolerance) << low << " to " << high;
    }
  };
  expectOneSided(slanted, 1e-4);
  expectOneSided(straight, 1e-4);
  expectOneSided(circle, 0.3);  // it is straight within each triangle: chords of up to 4 m
}

TEST(Tiling, FieldsOfOneSignCutNothing) {
  Tiling t = fineAt(0, 0);
  const std::size_t before = t.triangles.size();
  cutAlong(t, [](std::uint32_t) { return 1.0; });
  cutAlong(t, [](std::uint32_t) { return 0.0; });
  EXPECT_EQ(t.triangles.size(), before);
}

}  // namespace
}  // namespace scanmill::town
