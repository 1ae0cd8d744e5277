#include "viewer/frames/view_mesh.h"

#include <limits>

#include "base/parallel.h"
#include "base/random.h"
#include "tests/studio/viewer/window/fake_frames.h"
#include "tests/support/street.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"
#include "viewer/frames/frame_source.h"

namespace scanmill {

namespace {

using testing::HasSubstr;

double between(std::uint32_t bits, double low, double high) {
  return low + (high - low) * uniform(bits);
}

// Turned, scaled, mirrored spheres and boxes at coordinates of a map.
Scene farScene(std::size_t copies = 6) {
  SceneBuilder builder = testBuilder();
  Mesh ball = meshOf(builder, "thing");
  ball.surfaces.push_back(builder.surface("other", "dark"));
  ball.surfaces[0].node = "upper";
  ball.surfaces[1].node = "lower";
  appendSphere(ball, 0, {}, 1.0, 24);
  for (std::size_t t = 0; t < ball.triangles.size(); t += 2) ball.surfaceOf[t] = 1;
  const std::uint32_t balls = builder.addMesh(std::move(ball));
  Mesh block = meshOf(builder, "ground", "dark");
  appendBox(block, 0, {}, {2, 3, 1});
  const std::uint32_t blocks = builder.addMesh(std::move(block));
  for (std::uint32_t i = 0; i < copies; ++i) {
    const RandomBlock r = randomBlock({.beam = i});
    const Mat3 turn = toMatrix(fromYawPitchRoll(between(r[0], 0, 6), between(r[1], -1, 1), between(r[2], -1, 1)));
    const Vec3d size{between(r[3], 0.5, 2), i % 2 ? -1.0 : 1.0, 1.5};
    const Vec3d place{400000.0 + 7.3 * i, 5000000.0 + between(r[0], -9, 9), between(r[1], -2, 2)};
    builder.place(i % 3 == 2 ? blocks : balls, {turn * Mat3::scale(size), place}, "copy#" + std::to_string(i));
  }
  return builder.finish();
}

// What each triangle must be, one after the other.
void expectSame(const ViewMesh& view, const Scene& scene) {
  ASSERT_EQ(view.size(), scene.placedTriangles());
  ASSERT_EQ(view.corners.size(), 3 * view.size());
  std::size_t t = 0;
  Box bounds;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (std::size_t own = 0; own < mesh.triangles.size(); ++own, ++t) {
      const Surface& surface = mesh.surfaces[mesh.surfaceOf[own]];
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3d world = instance.worldFromMesh * Vec3d(mesh.positions[mesh.triangles[own][c]]);
        const Vec3d found(view.corners[3 * t + c]);
        ASSERT_LT(length(found - (world - view.origin)), 1e-7 * length(found) + 4e-9) << t;
        bounds.add(found);
      }
      ASSERT_EQ(view.semantic[t], surface.semantic);
      ASSERT_EQ(view.instance[t], instanceId(instance, surface));
      ASSERT_EQ(view.materials[view.surfaceOf(t).material], scene.materials[surface.material].name);
      ASSERT_EQ(view.reflectance[view.surfaceOf(t).material], scene.materials[surface.material].reflectance);
      const bool same = instance.name.substr(0, instance.name.find('#')) == surface.node;
      ASSERT_EQ(view.parts[view.surfaceOf(t).part],
                surface.node.empty() || same ? instance.name : instance.name + ": " + surface.node);
    }
  }
  EXPECT_EQ(view.bounds.low, bounds.low);
  EXPECT_EQ(view.bounds.high, bounds.high);
  EXPECT_EQ(view.boxes.size(), (view.size() + 255) / 256);
  EXPECT_EQ(view.ontology.classes.size(), scene.ontology.classes.size());
}

// The nearest of all triangles, by planes and edges instead of barycentric coordinates.
std::optional<MeshHit> nearestOfAll(const ViewMesh& mesh, const Vec3d& origin, const Vec3d& along) {
  MeshHit best{0, std::numeric_limits<double>::infinity()};
  for (std::size_t t = 0; t < mesh.size(); ++t) {
    const Vec3d a(mesh.corners[3 * t]);
    const Vec3d b(mesh.corners[3 * t + 1]);
    const Vec3d c(mesh.corners[3 * t + 2]);
    const Vec3d normal = cross(b - a, c - a);
    const double slope = dot(normal, along);
    if (slope == 0) continue;
    const double distance = dot(normal, a - origin) / slope;
    if (!(distance >= 0) || distance >= best.distance) continue;
    const Vec3d p = origin + along * distance;
    if (dot(cross(b - a, p - a), normal) < 0 || dot(cross(c - b, p - b), normal) < 0 ||
        dot(cross(a - c, p - c), normal) < 0) {
      continue;
    }
    best = {t, distance};
  }
  if (std::isinf(best.distance)) return std::nullopt;
  return best;
}

void expectPicksLikeAll(const ViewMesh& mesh, std::uint32_t rays, std::size_t leastHits) {
  std::size_t hits = 0;
  std::size_t others = 0;
  const Vec3d size = mesh.bounds.high - mesh.bounds.low;
  const auto inside = [&](const RandomBlock& r) {
    return mesh.bounds.low + Vec3d{size.x * uniform(r[0]), size.y * uniform(r[1]), size.z * uniform(r[2])};
  };
  for (std::uint32_t i = 0; i < rays; ++i) {
    const Vec3d from = inside(randomBlock({.beam = i})) * (i % 2 ? 1.0 : 3.0);
    const Vec3d to = inside(randomBlock({.frame = 1, .beam = i}));
    const auto found = pickTriangle(mesh, from, (to - from) * 0.3);
    const auto expected = nearestOfAll(mesh, from, normalized(to - from));
    ASSERT_EQ(found.has_value(), expected.has_value()) << i;
    if (!found) continue;
    ++hits;
    ASSERT_NEAR(found->distance, expected->distance, 1e-9 * (1 + expected->distance)) << i;
    const Vec3d a(mesh.corners[3 * found->triangle]);
    const Vec3d normal = normalized(
        cross(Vec3d(mesh.corners[3 * found->triangle + 1]) - a, Vec3d(mesh.corners[3 * found->triangle + 2]) - a));
    const Vec3d p = from + normalized(to - from) * found->distance;
    ASSERT_NEAR(dot(normal, p - a), 0, 1e-6) << i;
    others += found->triangle == expected->triangle ? 0 : 1;
  }
  EXPECT_LE(others, hits / 20);  // some surfaces coincide
  EXPECT_GT(hits, leastHits);
}

TEST(MakeViewMesh, PlacesEveryTriangle) {
  const Scene scene = farScene();
  const ViewMesh view = makeViewMesh(scene);
  EXPECT_EQ(view.problem, "");
  expectSame(view, scene);
  EXPECT_THAT(view.parts, testing::Contains("copy#0: upper"));
  EXPECT_THAT(view.parts, testing::Contains("copy#2"));
}

TEST(MakeViewMesh, TheSameWithAnyNumberOfThreads) {
  const Scene scene = farScene(80);
  const ViewMesh many = makeViewMesh(scene);
  const ThreadLimit one(1);
  const ViewMesh single = makeViewMesh(scene);
  EXPECT_EQ(many.corners, single.corners);
  EXPECT_EQ(many.surface, single.surface);
  EXPECT_EQ(many.surfaces, single.surfaces);
  EXPECT_EQ(many.instance, single.instance);
  EXPECT_EQ(many.origin, single.origin);
}

TEST(MakeViewMesh, TheQuickstartStreet) {
  const Scene scene = proceduralStreet();
  const ViewMesh view = makeViewMesh(scene);
  expectSame(view, scene);
  EXPECT_GT(view.size(), 1'000'000u);
  expectPicksLikeAll(view, 30, 10);
}

// Places a sphere of 5 m radius as a thing, with a node that is called as it is.
std::uint32_t addBall(SceneBuilder& builder, double radius = 5, std::uint32_t steps = 24) {
  Mesh ball = meshOf(builder, "thing");
  ball.surfaces[0].node = "ball";
  appendSphere(ball, 0, {}, radius, steps);
  return builder.addMesh(std::move(ball));
}

void addGround(SceneBuilder& builder, int tiles, double side) {
  Mesh ground = meshOf(builder, "ground");
  for (int i = 0; i < tiles; ++i) {
    for (int k = 0; k < tiles; ++k) {
      appendPlane(ground, 0, {{}, {side * (i - tiles / 2), side * (k - tiles / 2), 0}}, side, side);
    }
  }
  builder.place(builder.addMesh(std::move(ground)), at(0, 0, 0), "ground");
}

// The core is where most of a scene is, in the plane: `within` m of the expected corners.
void expectCore(SceneBuilder& builder, const Vec3d& low, const Vec3d& high, double within) {
  const ViewMesh view = makeViewMesh(builder.finish());
  for (const auto& [found, expected] : {std::pair(view.core.low, low), {view.core.high, high}}) {
    EXPECT_NEAR(found.x + view.origin.x, expected.x, within);
    EXPECT_NEAR(found.y + view.origin.y, expected.y, within);
  }
}

// Ground that reaches farther than all else does not count, however many triangles it has; if other parts reach as far,
// it counts. Nor does one thing of many triangles count for more than all around it.
TEST(MakeViewMesh, TheCoreIsWhereMostOfItIs) {
  SceneBuilder wide = testBuilder();
  addGround(wide, 1, 1000);
  wide.place(addBall(wide), at(30, -20, 5), "ball#2");
  expectCore(wide, {25, -25, 0}, {35, -15, 10}, 2);
  for (const double apart : {60.0, 240.0}) {  // m, from one ball to the other
    SceneBuilder fine = testBuilder();
    addGround(fine, 25, 10);
    const auto balls = addBall(fine);
    for (const double x : {-apart / 2, apart / 2}) fine.place(balls, at(x, 0, 5), "ball");
    const double x = apart < 100 ? 35 : 125, y = apart < 100 ? 5 : 125;
    expectCore(fine, {-x, -y, 0}, {x, y, 0}, 6);
  }
  SceneBuilder plain = testBuilder();
  Mesh block = meshOf(plain, "thing");
  appendBox(block, 0, {}, {4, 4, 4});
  const auto blocks = plain.addMesh(std::move(block));
  for (int i = 0; i < 20; ++i) plain.place(blocks, at(10.0 * (i % 5), 10.0 * (i / 5), 0), "block");
  plain.place(addBall(plain, 1, 200), at(5, 5, 2), "ball");
  expectCore(plain, {-2, -2, 0}, {42, 32, 0}, 5);
  SceneBuilder field = testBuilder();
  addGround(field, 1, 90);
  Mesh house = meshOf(field, "thing");
  appendBox(house, 0, {}, {8, 8, 6});
  const auto houses = field.addMesh(std::move(house));
  for (int i = 0; i < 8; ++i) field.place(houses, at(-30.0 + 20 * (i % 4), i < 4 ? -30 : 30, 0), "house");
  const auto plants = addBall(field, 0.1);
  for (int i = 0; i < 400; ++i) field.place(plants, at(32 + 0.3 * (i % 20), 2 + 0.3 * (i / 20), 0), "plant");
  expectCore(field, {-34, -34, 0}, {38, 34, 0}, 6);
}

TEST(MakeViewMesh, ASceneThatIsTooLargeIsAProblem) {
  SceneBuilder builder = testBuilder();
  Mesh ball = meshOf(builder, "thing");
  appendSphere(ball, 0, {}, 1.0, 100);
  const std::uint64_t each = ball.triangles.size();
  const std::uint32_t mesh = builder.addMesh(std::move(ball));
  for (std::uint64_t i = 0; i <= kMostViewTriangles / each; ++i) builder.place(mesh, at(double(i), 0, 0), "ball");
  const ViewMesh view = makeViewMesh(builder.finish());
  EXPECT_THAT(view.problem, testing::AllOf(HasSubstr("test"), HasSubstr("at most 30000000"), HasSubstr("--scene")));
  EXPECT_EQ(view.size(), 0u);
}

TEST(LoadViewMesh, ShowsWhatMovesWhereItIsUnlessThatIsFarAway) {
  const TemporaryFolder folder;
  const auto file =
      folder.write("moving.yaml", kSceneHead +
                                      "  - {primitive: plane, size: [20, 20], class: road, material: asphalt}\n"
                                      "  - {primitive: box, size: [1, 1, 1], class: car, material: car_paint, "
                                      "moving: {velocity: [10, 0, 0]}}\n");
  const ViewMesh start = loadViewMesh({file, 1});
  EXPECT_TRUE(start.moves);
  EXPECT_EQ(start.size(), 14u) << "two of the plane, twelve of the box";
  const ViewMesh later = loadViewMesh({file, 1, 2});
  EXPECT_EQ(later.size(), 14u);
  EXPECT_NEAR(later.origin.x + later.bounds.high.x, 20.5, 1e-5);
  EXPECT_EQ(loadViewMesh({file, 1, 20}).size(), 2u);
}

TEST(LoadViewMesh, ReadsAScene) {
  const std::string street = std::string(SCANMILL_SOURCE_DIR) + "/scenes/street.yaml";
  const ViewMesh first = loadViewMesh({street, 1});
  EXPECT_EQ(first.problem, "");
  EXPECT_EQ(first.size(), makeViewMesh(proceduralStreet()).size());
  EXPECT_NE(loadViewMesh({street, 2}).corners, first.corners);
}

TEST(LoadViewMesh, TakesTheClassesOfAnotherOntology) {
  const std::string source = SCANMILL_SOURCE_DIR;
  const ViewMesh own = loadViewMesh({source + "/scenes/street.yaml", 1});
  const ViewMesh other = loadViewMesh({source + "/scenes/street.yaml", 1, 0, source + "/labels/semantic_kitti.yaml"});
  ASSERT_EQ(other.size(), own.size());
  EXPECT_EQ(other.ontology.name, "semantic_kitti");
  const std::uint16_t road = own.ontology.find("road")->id;
  const std::uint16_t roadThere = other.ontology.find("road")->id;
  ASSERT_NE(road, roadThere);
  for (std::size_t t = 0; t < own.size(); ++t) {
    if (own.semantic[t] != road) continue;
    ASSERT_EQ(other.semantic[t], roadThere) << t;
  }
}

TEST(LoadViewMesh, ABadSceneIsAProblem) {
  const TemporaryFolder folder;
  EXPECT_THAT(loadViewMesh({folder.path() / "none.yaml", 1}).problem, HasSubstr("none.yaml"));
  const ViewMesh bad = loadViewMesh({folder.write("bad.yaml", "objects: [{primitive: bx}]\n"), 1});
  EXPECT_THAT(bad.problem, HasSubstr("bad.yaml:1"));
  EXPECT_EQ(bad.size(), 0u);
}

TEST(PickTriangle, TheFirstOfAll) {
  expectPicksLikeAll(makeViewMesh(farScene()), 600, 100);
}

TEST(PickTriangle, FlatAndAlongTheAxes) {
  SceneBuilder builder = testBuilder();
  Mesh floor = meshOf(builder, "ground");
  appendPlane(floor, 0, {}, 10, 10);
  builder.place(builder.addMesh(std::move(floor)), at(0, 0, 0.3), "floor");
  const ViewMesh mesh = makeViewMesh(builder.finish());
  for (const double side : {1.0, -1.0}) {  // both faces
    const auto hit = pickTriangle(mesh, {1, 2, 4 * side}, {0, 0, -3 * side});
    ASSERT_TRUE(hit);
    EXPECT_DOUBLE_EQ(hit->distance, 4);
    EXPECT_FALSE(pickTriangle(mesh, {1, 2, 4 * side}, {0, 0, side}));
    EXPECT_FALSE(pickTriangle(mesh, {11, 2, 4 * side}, {0, 0, -side}));
  }
  EXPECT_FALSE(pickTriangle(mesh, {0, 0, 1}, {}));
  EXPECT_FALSE(pickTriangle(mesh, {0, 0, 1}, {NAN, 0, 1}));
  EXPECT_FALSE(pickTriangle(mesh, {INFINITY, 0, 1}, {0, 0, -1}));
  EXPECT_FALSE(pickTriangle(ViewMesh{}, {0, 0, 1}, {0, 0, -1}));
}

}  // namespace

}  // namespace scanmill
