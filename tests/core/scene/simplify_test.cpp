#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "base/parallel.h"
#include "scene/scene.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

Scene sphereScene(int segments) {
  SceneBuilder builder = testBuilder();
  Mesh sphere = meshOf(builder, "thing");
  appendSphere(sphere, 0, {}, 2.0, segments);
  return sceneWith(builder, sphere);
}

std::map<std::uint16_t, std::size_t> perSurface(const Mesh& mesh) {
  std::map<std::uint16_t, std::size_t> count;
  for (const std::uint16_t s : mesh.surfaceOf) ++count[s];
  return count;
}

void expectSameMesh(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.uvs, b.uvs);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.surfaceOf, b.surfaceOf);
}

// A mesh that methods may trace: see Mesh.
void expectSound(const Mesh& mesh) {
  EXPECT_EQ(mesh.triangles.size(), mesh.surfaceOf.size());
  EXPECT_TRUE(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size());
  Mesh copy = mesh;
  EXPECT_EQ(clean(copy).total(), 0u);
  std::set<std::uint32_t> used;
  for (const Triangle& t : mesh.triangles) used.insert(t.begin(), t.end());
  EXPECT_EQ(used.size(), mesh.positions.size()) << "no vertex without a triangle";
}

// Every edge has its other side, whatever surface that is of.
bool closed(const Mesh& mesh) {
  using Point = std::tuple<float, float, float>;
  std::map<std::pair<Point, Point>, int> sides;
  const auto point = [&](std::uint32_t v) {
    const Vec3f& p = mesh.positions[v];
    return Point(p.x, p.y, p.z);
  };
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Point a = point(t[k]);
      const Point b = point(t[(k + 1) % 3]);
      if (a < b) {
        ++sides[{a, b}];
      } else {
        --sides[{b, a}];
      }
    }
  }
  return std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 0; });
}

// Returns the largest distance of corners and middles of triangles from a sphere of this radius (m).
double offSphere(const Mesh& mesh, double radius) {
  double largest = 0;
  for (const Triangle& t : mesh.triangles) {
    const auto [p, q, r] = cornersIn(mesh, t);
    for (const Vec3d& at : {p, (p + q + r) * (1.0 / 3)}) largest = std::max(largest, std::abs(length(at) - radius));
  }
  return largest;
}

TEST(Simplify, KeepingAllChangesNothing) {
  EXPECT_EQ(simplified({}, 0.5).triangles(), 0u);
  const Scene scene = proceduralStreet();
  const Scene same = simplified(scene, 1);
  ASSERT_EQ(same.meshes.size(), scene.meshes.size());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) expectSameMesh(same.meshes[m], scene.meshes[m]);
}

TEST(Simplify, ShareIsReachedAndTheShapeStays) {
  const Scene scene = sphereScene(128);
  const double all = static_cast<double>(scene.triangles());
  for (const double keep : {0.9, 0.5, 0.25, 0.1, 0.05, 0.02}) {
    const Scene fewer = simplified(scene, keep);
    EXPECT_NEAR(static_cast<double>(fewer.triangles()), keep * all, 4) << keep;
    expectSound(fewer.meshes[0]);
    EXPECT_TRUE(closed(fewer.meshes[0])) << keep;
    // A sphere of n even triangles has a sagitta of about 4 pi r / (3 sqrt(3) n).
    const double even = 4 * kPi * 2 / (3 * std::sqrt(3.0) * static_cast<double>(fewer.triangles()));
    EXPECT_LT(offSphere(fewer.meshes[0], 2), 10 * even) << keep;
  }
}

TEST(Simplify, FlatGroundStaysFlatAndAsLarge) {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 50, 30, 40);
  const Scene fewer = simplified(sceneWith(builder, ground), 0.05);
  const Box box = fewer.bounds();
  EXPECT_EQ(box.low, (Vec3d{-25, -15, 0}));
  EXPECT_EQ(box.high, (Vec3d{25, 15, 0}));
  double area = 0;
  const Mesh& mesh = fewer.meshes[0];
  EXPECT_LE(mesh.triangles.size(), 160u);
  for (const Triangle& t : mesh.triangles) {
    const double upwards = normalIn(mesh, t).z;
    EXPECT_GT(upwards, 0);
    area += upwards / 2;
  }
  EXPECT_NEAR(area, 1500, 1e-3) << "no hole, nothing twice";
}

// Bands of a sphere are of different things and materials: they stay apart, and the sphere stays closed.
TEST(Simplify, SurfacesStayApartAndClosed) {
  SceneBuilder builder = testBuilder();
  Mesh sphere = meshOf(builder, "thing");
  sphere.surfaces.push_back(builder.surface("ground", "dark"));
  sphere.surfaces.push_back(builder.surface("other", "grey"));
  sphere.surfaces[2].object = 2;
  appendSphere(sphere, 0, {}, 2.0, 96);
  const auto surfaceAt = [](const Vec3d& p) { return p.z > 0.7 ? 0 : p.x > 0 ? 1 : 2; };
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    const auto [a, b, c] = cornersIn(sphere, sphere.triangles[t]);
    sphere.surfaceOf[t] = static_cast<std::uint16_t>(surfaceAt((a + b + c) * (1.0 / 3)));
  }
  const Scene scene = sceneWith(builder, sphere);
  for (const double keep : {0.5, 0.2, 0.05}) {
    const Scene fewer = simplified(scene, keep);
    const Mesh& mesh = fewer.meshes[0];
    EXPECT_LE(static_cast<double>(mesh.triangles.size()), 1.1 * keep * static_cast<double>(sphere.triangles.size()));
    EXPECT_EQ(mesh.objects, scene.meshes[0].objects);
    EXPECT_TRUE(closed(mesh)) << keep;
    expectSound(mesh);
    EXPECT_EQ(perSurface(mesh).size(), 3u);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      // Corners lie where the surface was: within a triangle's size of its border.
      for (const std::uint32_t v : mesh.triangles[t]) {
        const Vec3d p(mesh.positions[v]);
        const double beyond = mesh.surfaceOf[t] == 0   ? 0.7 - p.z
                              : mesh.surfaceOf[t] == 1 ? std::max(p.z - 0.7, -p.x)
                                                       : std::max(p.z - 0.7, p.x);
        EXPECT_LT(beyond, 0.2);
      }
    }
  }
}

TEST(Simplify, FewTrianglesStay) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {1, 2, 3});
  const Scene scene = sceneWith(builder, box);
  expectSameMesh(simplified(scene, 0.01).meshes[0], scene.meshes[0]);
}

// A small surface on a large mesh is worth less than any fold of that, and yet it stays.
TEST(Simplify, SmallSurfacesDoNotVanish) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "ground");
  mesh.surfaces.push_back(builder.surface("thing", "dark"));
  appendSphere(mesh, 0, {}, 20.0, 64);
  appendSphere(mesh, 1, at(0, 0, 25), 0.05, 24);
  const std::size_t small = mesh.triangles.size();
  mesh.surfaces.push_back(builder.surface("other", "grey"));
  mesh.surfaces[2].object = 2;
  appendBox(mesh, 2, at(0, 0, 26), {0.01, 0.01, 0.01});
  ASSERT_GT(small, 2000u);
  const Scene fewer = simplified(sceneWith(builder, mesh), 0.05);
  const auto count = perSurface(fewer.meshes[0]);
  ASSERT_EQ(count.size(), 3u);
  EXPECT_LE(count.at(2), 12u);
  expectSound(fewer.meshes[0]);
}

TEST(Simplify, TexturesStayWhereTheyAre) {
  SceneBuilder builder = testBuilder();
  Material paint;
  paint.name = "paint";
  paint.texture = std::make_shared<Texture>();
  Mesh ground;
  ground.name = "ground";
  ground.surfaces.push_back({builder.addMaterial(paint), 1, 0, "", "", {}});
  appendPlane(ground, 0, {}, 8, 8, 32);
  for (const Vec3f& p : ground.positions) ground.uvs.push_back({p.x / 8, p.y / 8});
  const Scene fewer = simplified(sceneWith(builder, ground), 0.1);
  const Mesh& mesh = fewer.meshes[0];
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  for (std::size_t v = 0; v < mesh.uvs.size(); ++v) {
    EXPECT_EQ(mesh.uvs[v], (Vec2f{mesh.positions[v].x / 8, mesh.positions[v].y / 8}));
  }
}

TEST(Simplify, ThreadsDoNotMatter) {
  const Scene scene = proceduralStreet();
  std::vector<Scene> results;
  for (const int threads : {1, 4}) {
    const ThreadLimit limit(threads);
    results.push_back(simplified(scene, 0.3));
  }
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) expectSameMesh(results[0].meshes[m], results[1].meshes[m]);
}

TEST(Simplify, SharesThatMeanNothingAreRefused) {
  const Scene scene = sphereScene(16);
  for (const double keep : {0.0, -0.5, 1.01, std::nan("")})
    EXPECT_THROW(static_cast<void>(simplified(scene, keep)), Error);
}

}  // namespace
}  // namespace scanmill
