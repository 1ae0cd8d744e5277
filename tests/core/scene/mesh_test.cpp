#include <limits>

#include "scene/primitives.h"
#include "scene/scene.h"

namespace scanmill {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Mesh withTriangles(std::vector<Vec3f> positions, std::vector<Triangle> triangles) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  mesh.triangles = std::move(triangles);
  mesh.surfaceOf.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.surfaceOf.size(); ++i) mesh.surfaceOf[i] = static_cast<std::uint16_t>(i);
  mesh.surfaces.resize(mesh.triangles.size());
  return mesh;
}

TEST(Clean, countsEachFaultAndKeepsTheOrderOfTheRest) {
  Mesh mesh = withTriangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {kNan, 0, 0}, {0, -kInfinity, 0}, {2, 0, 0}},
                            {{0, 1, 2},            // good
                             {0, 1, 3},            // NaN
                             {0, 4, 2},            // infinite
                             {0, 1, 1},            // a corner twice
                             {0, 1, 5},            // in line
                             {0, 1, 6},            // out of range
                             {0, 1, 4294967295u},  // out of range
                             {2, 1, 5}});          // good
  const Dropped dropped = clean(mesh);
  EXPECT_EQ(dropped.nonFinite, 2u);
  EXPECT_EQ(dropped.degenerate, 2u);
  EXPECT_EQ(dropped.outOfRange, 2u);
  EXPECT_EQ(dropped.total(), 6u);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 5}}));
  EXPECT_EQ(mesh.surfaceOf, (std::vector<std::uint16_t>{0, 7}));
  for (const Vec3f& p : mesh.positions) EXPECT_TRUE(isFinite(p));
  EXPECT_EQ(clean(mesh).total(), 0u);
}

TEST(Clean, inLineCornersAreDegenerateWhateverTheirDirection) {
  // Multiples of a direction with few bits: exactly in line in float32.
  const Vec3f d{0.375f, -1.25f, 3.0f};
  Mesh mesh = withTriangles({d * 3, d * 7, d * 1024}, {{0, 1, 2}, {2, 0, 1}});
  EXPECT_EQ(clean(mesh).degenerate, 2u);
}

TEST(Clean, tinyHugeAndThinTrianglesStay) {
  Mesh mesh = withTriangles({{0, 0, 0},
                             {1e-6f, 0, 0},
                             {0, 1e-6f, 0},
                             {1e5f, 0, 0},
                             {0, 1e5f, 0},
                             {100, 0, 0},
                             {50, 4e-6f, 0},
                             {1e18f, 0, 0},
                             {0, 1e18f, 0},
                             {1e-18f, 0, 0},
                             {0, 1e-18f, 0}},
                            {{0, 1, 2}, {0, 3, 4}, {0, 5, 6}, {0, 7, 8}, {0, 9, 10}, {1, 3, 4}});
  EXPECT_EQ(clean(mesh).total(), 0u);
}

TEST(Bounds, ignoreVerticesThatNoTriangleUses) {
  Mesh mesh = withTriangles({{5, 5, 5}, {6, 5, 5}, {5, 6, 5}, {kNan, 0, 0}}, {{0, 1, 2}, {0, 1, 3}});
  static_cast<void>(clean(mesh));
  EXPECT_EQ(mesh.bounds().low, (Vec3d{5, 5, 5}));
  EXPECT_EQ(mesh.bounds().high, (Vec3d{6, 6, 5}));
  EXPECT_TRUE(Mesh{}.bounds().empty());
}

TEST(Scene, countsAndBoundsOfCopies) {
  Scene scene;
  Mesh box;
  box.surfaces.resize(1);
  box.surfaces[0].object = 1;
  box.objects = 1;
  appendBox(box, 0, {}, {2, 4, 6});
  scene.meshes = {box};
  scene.instances.push_back({0, {{}, {10, 0, 0}}, 1, "a"});
  scene.instances.push_back({0, {Mat3::scale({-1, 1, 2}), {0, -3, 0}}, 2, "b"});
  EXPECT_EQ(scene.triangles(), 12u);
  EXPECT_EQ(scene.placedTriangles(), 24u);
  EXPECT_EQ(scene.things(), 2u);
  EXPECT_EQ(scene.bounds().low, (Vec3d{-1, -5, -6}));
  EXPECT_EQ(scene.bounds().high, (Vec3d{11, 2, 6}));
}

TEST(Scene, boundsHoldEveryPlacedVertex) {
  Scene scene;
  Mesh sphere;
  sphere.surfaces.resize(1);
  appendSphere(sphere, 0, {}, 1, 16);
  scene.meshes = {sphere};
  const Affine place{toMatrix(fromYawPitchRoll(0.5, 0.2, -0.7)) * Mat3::scale({3, 1, 2}), {1e6, -2e6, 30}};
  scene.instances.push_back({0, place, 0, "s"});
  const Box box = scene.bounds();
  for (const Vec3f& p : sphere.positions) {
    const Vec3d w = place * Vec3d(p);
    EXPECT_TRUE(box.low.x <= w.x && w.x <= box.high.x && box.low.y <= w.y && w.y <= box.high.y && box.low.z <= w.z &&
                w.z <= box.high.z);
  }
}

}  // namespace
}  // namespace scanmill
