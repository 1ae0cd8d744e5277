#include "scene/builder.h"

#include <limits>

#include "scene/primitives.h"
#include "tests/support/labels.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

Mesh box(const Surface& surface) {
  Mesh mesh;
  mesh.name = "box";
  mesh.surfaces = {surface};
  appendBox(mesh, 0, {}, {1, 1, 1});
  return mesh;
}

TEST(SceneBuilder, materialsAreAddedOnce) {
  SceneBuilder builder = labelledBuilder();
  EXPECT_EQ(builder.material("default", {}), 0);
  const std::uint16_t glass = builder.material("glass", {});
  EXPECT_EQ(glass, 1);
  EXPECT_EQ(builder.material("wood", {}), 2);
  EXPECT_EQ(builder.material("glass", {}), glass);

  Material own;
  own.name = "own";
  const std::uint16_t first = builder.addMaterial(own);
  EXPECT_EQ(builder.addMaterial(own), first);
  own.texture = std::make_shared<Texture>();
  const std::uint16_t textured = builder.addMaterial(own);
  EXPECT_NE(textured, first);
  own.alphaCutoff = 0.25f;
  EXPECT_NE(builder.addMaterial(own), textured);
}

TEST(SceneBuilder, surfacesOfThingsAreObjects) {
  SceneBuilder builder = labelledBuilder();
  const Surface car = builder.surface("car", "car_paint");
  EXPECT_EQ(car.semantic, 20);
  EXPECT_EQ(car.object, 1u);
  const Surface road = builder.surface("street", "asphalt");  // by alias
  EXPECT_EQ(road.semantic, 1);
  EXPECT_EQ(road.object, 0u);
  expectInputError([&] { builder.surface("carr", "glass", {"a.yaml", 1, 2}); }, {"a.yaml:1:2", "'carr'", "car"});
  expectInputError([&] { builder.surface("car", "glas", {"a.yaml", 1, 2}); }, {"a.yaml:1:2", "'glas'", "glass"});
}

TEST(SceneBuilder, instanceIdsFollowTheOrderOfPlacement) {
  SceneBuilder builder = labelledBuilder("test", 5);
  const std::uint32_t road = builder.addMesh(box(builder.surface("road", "asphalt")));
  const std::uint32_t car = builder.addMesh(box(builder.surface("car", "car_paint")));
  Mesh pair = box(builder.surface("car", "car_paint"));
  pair.surfaces.push_back(pair.surfaces[0]);
  pair.surfaces[1].object = 2;
  appendBox(pair, 1, {{}, {3, 0, 0}}, {1, 1, 1});
  const std::uint32_t two = builder.addMesh(pair);

  builder.place(car, {}, "first");
  builder.place(road, {}, "road");
  builder.place(two, {}, "two");
  builder.place(car, {{}, {0, 9, 0}}, "last");
  const Scene scene = builder.finish();
  EXPECT_EQ(scene.seed, 5u);
  EXPECT_EQ(scene.things(), 4u);
  const auto id = [&](std::size_t instance, std::size_t surface) {
    const Instance& i = scene.instances[instance];
    return instanceId(i, scene.meshes[i.mesh].surfaces[surface]);
  };
  EXPECT_EQ(id(0, 0), 1u);
  EXPECT_EQ(id(1, 0), 0u);
  EXPECT_EQ(id(2, 0), 2u);
  EXPECT_EQ(id(2, 1), 3u);
  EXPECT_EQ(id(3, 0), 4u);
}

TEST(SceneBuilder, brokenTrianglesAreDroppedAndCounted) {
  SceneBuilder builder = labelledBuilder();
  Mesh mesh = box(builder.surface("road", "asphalt"));
  mesh.positions[0].x = std::numeric_limits<float>::quiet_NaN();
  mesh.triangles[3] = {7, 8, 9};
  builder.place(builder.addMesh(mesh), {}, "box");
  builder.addDropped({.degenerate = 4});
  const Scene scene = builder.finish();
  EXPECT_EQ(scene.dropped.degenerate, 4u);
  EXPECT_EQ(scene.dropped.outOfRange, 1u);
  EXPECT_GE(scene.dropped.nonFinite, 4u);
  EXPECT_EQ(scene.triangles() + scene.dropped.nonFinite + scene.dropped.outOfRange, 12u);
}

TEST(SceneBuilder, transformsThatCannotBeUndoneAreRefused) {
  SceneBuilder builder = labelledBuilder();
  const std::uint32_t mesh = builder.addMesh(box(builder.surface("road", "asphalt")));
  const Location where{"s.yaml", 9, 3};
  const auto refuse = [&](const Affine& a) {
    expectInputError([&] { builder.place(mesh, a, "thing", where); }, {"s.yaml:9:3", "'thing'"});
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuse({Mat3::scale({1, 0, 1}), {}});
  refuse({{{1, 2, 3}, {2, 4, 6}, {0, 0, 1}}, {}});
  refuse({Mat3::scale({1, nan, 1}), {}});
  refuse({{}, {0, nan, 0}});
  refuse({{}, {INFINITY, 0, 0}});
  refuse({Mat3::scale({1e-200, 1e-200, 1e-200}), {}});
  EXPECT_NO_THROW(builder.place(mesh, {Mat3::scale({-1, 1, 1}), {}}, "mirrored", where));
  EXPECT_NO_THROW(builder.place(mesh, {Mat3::scale({1e-6, 1e6, 1}), {1e7, 1e7, 0}}, "odd", where));
}

TEST(SceneBuilder, meshesThatContradictThemselvesAreErrors) {
  SceneBuilder builder = labelledBuilder();
  Mesh mesh = box(builder.surface("road", "asphalt"));
  mesh.surfaceOf[2] = 1;
  EXPECT_THROW(static_cast<void>(builder.addMesh(mesh)), Error);
  mesh.surfaceOf.pop_back();
  EXPECT_THROW(static_cast<void>(builder.addMesh(mesh)), Error);
}

// Half of the places lie below the middle reflectance and half above, evenly in the logarithm; the same seed gives the
// same reflectance, whatever other materials there are.
TEST(SceneBuilder, reflectancesOfPlaces) {
  MaterialLibrary library;
  for (const char* name : {"first", "ranged", "fixed"}) {
    Material& m = library.materials.emplace_back();
    m.name = name;
    m.reflectance = m.least = m.greatest = 0.2f;
  }
  library.materials[1].least = 0.1f;
  library.materials[1].greatest = 0.8f;
  MaterialLibrary alone;
  alone.materials = {library.materials[1]};
  constexpr int kPlaces = 4000;
  int below = 0;
  double logarithms = 0;
  for (int seed = 0; seed < kPlaces; ++seed) {
    SceneBuilder builder("place", static_cast<std::uint64_t>(seed), {}, library);
    builder.drawReflectances();
    const float drawn = builder.library().require("ranged", {}).reflectance;
    EXPECT_GE(drawn, 0.1f);
    EXPECT_LE(drawn, 0.8f);
    below += drawn < 0.2f ? 1 : 0;
    logarithms += std::log2(drawn / 0.2);
    EXPECT_EQ(builder.library().require("fixed", {}).reflectance, 0.2f);
    SceneBuilder other("place", static_cast<std::uint64_t>(seed), {}, alone);
    other.drawReflectances();
    EXPECT_EQ(other.library().require("ranged", {}).reflectance, drawn);
  }
  EXPECT_NEAR(below, kPlaces / 2, 4 * std::sqrt(kPlaces) / 2);
  EXPECT_NEAR(logarithms / kPlaces, 0.25, 0.06);  // the mean of -1/2 and 1, with a deviation of 0.85
}

TEST(SceneBuilder, anEmptySceneIsRefused) {
  SceneBuilder builder = labelledBuilder();
  static_cast<void>(builder.addMesh(box(builder.surface("road", "asphalt"))));  // never placed
  expectInputError([&] { static_cast<void>(builder.finish()); }, {"'test'", "no triangle"});
}

}  // namespace
}  // namespace scanmill
