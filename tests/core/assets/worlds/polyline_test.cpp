#include "assets/worlds/solids.h"
#include "world_files.h"

namespace scanmill {
namespace {

class Polylines : public WorldFiles {
 protected:
  Mesh extruded(const std::string& polylines) const {
    return extrudedPolylines(readXml(folder_.write("g.xml", "<geometry>\n" + polylines + "</geometry>")));
  }
  static std::string polyline(const std::vector<Vec2d>& points, const std::string& height = "3") {
    std::string text = "<polyline>\n<height>" + height + "</height>";
    for (const Vec2d& p : points) text += "<point>" + std::to_string(p.x) + " " + std::to_string(p.y) + "</point>";
    return text + "</polyline>\n";
  }
  static std::string square(double x, double y, double half, bool clockwise = false) {
    std::vector<Vec2d> p{{x - half, y - half}, {x + half, y - half}, {x + half, y + half}, {x - half, y + half}};
    if (clockwise) std::reverse(p.begin(), p.end());
    return polyline(p);
  }
  // Returns the volume that the triangles enclose: it is right only if all of them face outwards and leave no gap.
  static double volumeOf(const Mesh& mesh) {
    double volume = 0;
    for (const Triangle& t : mesh.triangles) {
      volume += dot(Vec3d(mesh.positions[t[0]]), cross(Vec3d(mesh.positions[t[1]]), Vec3d(mesh.positions[t[2]]))) / 6;
    }
    return volume;
  }
  // Returns the area of all triangles that face up.
  static double ceilingOf(const Mesh& mesh) {
    double area = 0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3d a(mesh.positions[t[0]]), b(mesh.positions[t[1]]), c(mesh.positions[t[2]]);
      area += std::max(cross(b - a, c - a).z / 2, 0.0);
    }
    return area;
  }
};

TEST_F(Polylines, AreExtrudedFromZeroToTheirHeight) {
  for (const bool clockwise : {false, true}) {
    const Mesh mesh = extruded(square(10, 20, 2, clockwise));
    EXPECT_EQ(mesh.bounds().low, (Vec3d{8, 18, 0}));
    EXPECT_EQ(mesh.bounds().high, (Vec3d{12, 22, 3}));
    EXPECT_EQ(mesh.triangles.size(), 12u);
    EXPECT_NEAR(volumeOf(mesh), 48, 1e-4);
  }
  // An L, whose last point repeats the first.
  const Mesh bent = extruded(polyline({{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}, {0, 0}}));
  EXPECT_NEAR(volumeOf(bent), 21, 1e-4);
  EXPECT_NEAR(ceilingOf(bent), 7, 1e-5);
}

// The height is that of the first polyline; an outline in a hole is solid.
TEST_F(Polylines, WithinOthersAreHoles) {
  const Mesh yards = extruded(square(0, 0, 10) + square(-5, 1, 2) + square(5, -1, 2, true) + square(5, 6, 1) +
                              polyline({{-5, 0}, {-4, 0}, {-5, 1}}, "7"));
  const double area = 400 - 16 - 16 - 4 + 0.5;
  EXPECT_NEAR(ceilingOf(yards), area, 1e-4);
  EXPECT_NEAR(volumeOf(yards), 3 * area, 1e-3);
  EXPECT_EQ(yards.bounds().high.z, 3);
}

TEST_F(Polylines, ManyHolesInARowLeaveTheRest) {
  std::string all = square(0, 0, 100);
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column)
      all += square(column * 20 - 80, row * 20 - 80, 6, (row + column) % 2 == 0);
  }
  const Mesh mesh = extruded(all);
  EXPECT_NEAR(ceilingOf(mesh), 40000 - 81 * 144, 1);
  EXPECT_NEAR(volumeOf(mesh), 3 * (40000 - 81 * 144), 5);
}

TEST_F(Polylines, MistakesAreNamedWithTheirLine) {
  std::vector<Vec2d> circle;
  for (int i = 0; i < 40000; ++i)
    circle.push_back({1000 * std::cos(i * kPi / 20000), 1000 * std::sin(i * kPi / 20000)});
  expectRefusals([&](const std::string& text) { return messageOf([&] { extruded(text); }); },
                 {{polyline({{0, 0}, {1, 1}}), "g.xml:2 | encloses no area"},
                  {polyline({{0, 0}, {1, 1}, {2, 2}}), "encloses no area"},
                  {polyline({{0, 0}, {1, 0}, {1, 1e6}}), "more than 100 km away"},
                  {polyline({{0, 0}, {1, 0}, {1, 1}}, "0"), "the height 0, but it must be above 0"},
                  {square(0, 0, 1) + "<polyline><point>1</point></polyline>", "1 numbers"},
                  {polyline(circle), "40000 points: give them as a mesh"}});
}

TEST_F(Polylines, OfASdfAreParts) {
  const Asset asset = sdf(model(square(0, 0, 2) + square(0, 0, 1)));
  EXPECT_EQ(asset.parts.at(0).node, "m/l/v");
  EXPECT_EQ(boundsOf(asset).high, (Vec3d{2, 2, 3}));
}

}  // namespace
}  // namespace scanmill
