#include "assets/meshes/polygon.h"

#include <random>

namespace scanmill {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Triangles divided(const std::vector<Vec3d>& corners) {
  return Triangulator({"a.obj"}).divide(corners.size(), [&](std::size_t i) { return corners[i]; });
}

// Returns the area of each triangle along a direction: negative if the triangle is turned over.
std::vector<double> areas(const std::vector<Vec3d>& corners, const Vec3d& normal) {
  std::vector<double> areas;
  for (const auto& t : divided(corners)) {
    areas.push_back(dot(cross(corners[t[1]] - corners[t[0]], corners[t[2]] - corners[t[0]]), normal) / 2);
  }
  return areas;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values) total += value;
  return total;
}

// Triangles that are all turned as the polygon, and whose areas add up to the polygon's, cover it once.
TEST(Polygon, IsCoveredOnceInAnyPlane) {
  std::mt19937 random(5);
  const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  for (int round = 0; round < 300; ++round) {
    const int corners = 4 + round % 17;
    const Vec3d normal = normalized(Vec3d{unit(), unit(), unit()});
    const Vec3d u = normalized(cross(normal, std::abs(normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
    const Vec3d v = cross(normal, u);
    std::vector<Vec3d> star;  // seen from its middle, each corner is in another direction: simple, but seldom convex
    double area = 0;
    std::vector<double> radii;
    for (int i = 0; i < corners; ++i) radii.push_back(1.2 + unit());
    const double step = 2 * std::acos(-1.0) / corners;
    for (int i = 0; i < corners; ++i) {
      const double r = radii[static_cast<std::size_t>(i)];
      star.push_back(Vec3d{100, -50, 7} + u * (r * std::cos(i * step)) + v * (r * std::sin(i * step)));
      area += r * radii[static_cast<std::size_t>((i + 1) % corners)] * std::sin(step) / 2;
    }
    const std::vector<double> parts = areas(star, normal);
    EXPECT_EQ(parts.size(), star.size() - 2);
    for (const double part : parts) EXPECT_GT(part, -1e-9);
    EXPECT_NEAR(sum(parts), area, 1e-9);
  }
}

// Exporters write corners twice, and outlines that touch themselves in a corner.
TEST(Polygon, MayRepeatCornersAndTouchItself) {
  const std::vector<Vec3d> u{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    std::vector<Vec3d> corners;
    const std::size_t first = random() % u.size();
    for (std::size_t i = 0; i < u.size(); ++i) {
      const Vec3d& corner = u[(first + i) % u.size()];
      corners.insert(corners.end(), 1 + (random() % 3 == 0 ? 1 : 0), corner);
      const Vec3d& next = u[(first + i + 1) % u.size()];
      if (random() % 4 == 0) corners.push_back((corner + next) * 0.5);
    }
    const std::vector<double> parts = areas(corners, {0, 0, 1});
    EXPECT_EQ(parts.size(), corners.size() - 2);
    for (const double part : parts) EXPECT_GE(part, 0);
    EXPECT_NEAR(sum(parts), 7, 1e-12);
  }
  // Two squares that share a corner; a square with a notch that reaches the opposite side.
  const std::vector<Vec3d> twins{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 1, 0},
                                 {2, 2, 0}, {1, 2, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<Vec3d> notch{{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {4, 4, 0},
                                 {3, 4, 0}, {2, 0, 0}, {1, 4, 0}, {0, 4, 0}};
  for (std::size_t first = 0; first < 8; ++first) {
    for (const auto& [shape, area] : {std::pair(twins, 2.0), {notch, 12.0}}) {
      std::vector<Vec3d> turned = shape;
      std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(first), turned.end());
      const std::vector<double> parts = areas(turned, {0, 0, 1});
      for (const double part : parts) EXPECT_GE(part, 0) << first << ", area " << area;
      EXPECT_NEAR(sum(parts), area, 1e-12) << first;
    }
  }
}

TEST(Polygon, DegenerateOnesEnd) {
  const std::vector<Vec3d> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(divided(line).size(), 3u);
  const std::vector<Vec3d> bow{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(divided(bow).size(), 2u);
  EXPECT_EQ(divided({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}).size(), 1u);
  const double nan = std::nan("");
  EXPECT_EQ(divided({{0, 0, 0}, {nan, 0, 0}, {1, 1, 0}, {0, 1, 0}}).size(), 2u);
}

// An arm between two spirals of many turns: nearly every corner that is tried is no ear.
TEST(Polygon, StopsWhereASpiralTakesTooLong) {
  constexpr int kSpiralCorners = 4000;
  std::vector<Vec3d> spiral;
  for (const bool inward : {false, true}) {
    for (int i = 0; i < kSpiralCorners / 2; ++i) {
      const double angle = 0.1 * (inward ? kSpiralCorners / 2 - 1 - i : i);
      const double radius = 1 + angle + (inward ? 1.5 : 0);
      spiral.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
  }
  const auto corner = [&](std::size_t i) { return spiral[i]; };
  const double fewest = kSpiralCorners * double{kSpiralCorners} / 2;
  Triangulator polygons({"a.obj"});
  EXPECT_EQ(polygons.divide(spiral.size(), corner).size(), spiral.size() - 2);
  for (const double most : {fewest, 2 * fewest}) {
    EXPECT_THROW(Triangulator({"a.obj"}, most).divide(spiral.size(), corner), InputError) << most;
  }
}

}  // namespace
}  // namespace scanmill
