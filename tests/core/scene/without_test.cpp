#include "scene/scene.h"
#include "scene/thing_boxes.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

std::vector<Value> items(const std::string& list) {
  return parseYaml(list, "list").items;
}

// Two boxes, each a thing of its own, on a plate that is none.
Mesh twoOnAPlate(SceneBuilder& builder) {
  Mesh mesh = meshOf(builder, "ground");
  appendPlane(mesh, 0, {}, 20, 20);
  for (const std::uint32_t object : {1u, 2u}) {
    Surface surface = builder.surface("thing", "grey");
    surface.object = object;
    mesh.surfaces.push_back(surface);
    appendBox(mesh, static_cast<std::uint16_t>(object), at(object * 4.0, 0, 1), {1, 1, 2});
  }
  mesh.objects = 2;
  return mesh;
}

// Two copies of such a mesh: the things 1 and 2, and, `away` metres beside them, 3 and 4.
Scene twoCopies(const std::string& second, double away = 30) {
  SceneBuilder builder = testBuilder();
  const std::uint32_t mesh = builder.addMesh(twoOnAPlate(builder));
  builder.place(mesh, {}, "first");
  builder.place(mesh, at(0, away, 0), second);
  return builder.finish();
}

std::vector<std::uint32_t> idsOf(const Scene& scene) {
  std::vector<std::uint32_t> ids;
  const ThingBoxes boxes(scene);
  for (const Thing& thing : boxes.things()) ids.push_back(thing.id);
  return ids;
}

// Copies of a mesh share it; what one of them loses the others keep.
TEST(Without, AThingOfASharedMesh) {
  Scene scene = twoCopies("second");
  ASSERT_EQ(idsOf(scene), (std::vector<std::uint32_t>{1, 2, 3, 4}));
  const std::uint64_t before = scene.placedTriangles();
  takeOut(scene, items("[3]"));
  EXPECT_EQ(idsOf(scene), (std::vector<std::uint32_t>{1, 2, 4}));
  EXPECT_EQ(scene.placedTriangles(), before - 12);
  takeOut(scene, items("[1, 2]"));
  EXPECT_EQ(idsOf(scene), (std::vector<std::uint32_t>{4}));
  EXPECT_EQ(scene.instances.size(), 2u) << "the plates stay";
}

TEST(Without, AClassInAllMeshes) {
  Scene scene = twoCopies("second");
  takeOut(scene, items("[thing]"));
  EXPECT_TRUE(idsOf(scene).empty());
  EXPECT_EQ(scene.placedTriangles(), 4u);
  takeOut(scene, items("[ground]"));
  EXPECT_TRUE(scene.instances.empty());
}

TEST(Without, ObjectsByTheirName) {
  Scene scene = twoCopies("17");
  takeOut(scene, items("[first]"));
  EXPECT_EQ(idsOf(scene), (std::vector<std::uint32_t>{3, 4}));
  takeOut(scene, items("['17']"));
  EXPECT_TRUE(scene.instances.empty()) << "a number in quotes is a name";
}

// Meshes that a file places several times, of an object with two copies.
TEST(Without, ObjectsOfSeveralMeshesByTheirName) {
  const auto namesWithout = [](const std::string& item) {
    SceneBuilder builder = testBuilder();
    const std::uint32_t mesh = builder.addMesh(twoOnAPlate(builder));
    for (const char* const name : {"a#1", "a#1/post 1", "a#2/post 1", "a#10/post 1", "a/b", "ab/post 1"}) {
      builder.place(mesh, {}, name);
    }
    Scene scene = builder.finish();
    takeOut(scene, items(item));
    std::vector<std::string> names;
    for (const Instance& i : scene.instances) names.push_back(i.name);
    return names;
  };
  EXPECT_THAT(namesWithout("[a]"), testing::ElementsAre("a/b", "ab/post 1"));
  EXPECT_THAT(namesWithout("['a#1']"), testing::ElementsAre("a#2/post 1", "a#10/post 1", "a/b", "ab/post 1"));
}

TEST(Without, AThingInEveryMomentOfItsAnimation) {
  SceneBuilder builder = testBuilder();
  const auto walk = std::make_shared<Animation>();
  for (int i = 0; i < 3; ++i) walk->meshes.push_back(builder.addMesh(twoOnAPlate(builder)));
  builder.place(walk->meshes[0], {}, "walker");
  Scene scene = builder.finish();
  scene.instances[0].animation = walk;
  takeOut(scene, items("[2]"));
  EXPECT_EQ(idsOf(scene), (std::vector<std::uint32_t>{1}));
  ASSERT_EQ(scene.instances.size(), 1u);
  for (const double time : {0.0, 0.4, 0.7}) {
    EXPECT_EQ(scene.meshes[scene.instances[0].meshAt(time)].triangles.size(), 14u) << time;
  }
}

TEST(Without, NothingThatIsNotThere) {
  SceneBuilder builder = testBuilder();
  builder.place(builder.addMesh(twoOnAPlate(builder)), {}, "first");
  Scene scene = builder.finish();
  EXPECT_THAT(messageOf([&] { takeOut(scene, items("[9]")); }), testing::HasSubstr("list:1:2"));
  EXPECT_THAT(messageOf([&] { takeOut(scene, items("[0]")); }), testing::HasSubstr("has the instance id 0"));
  EXPECT_THAT(messageOf([&] { takeOut(scene, items("[frist]")); }), testing::HasSubstr("did you mean 'first'"));
  EXPECT_THAT(messageOf([&] { takeOut(scene, items("['first#2']")); }), testing::HasSubstr("did you mean 'first'"));
  EXPECT_EQ(idsOf(scene), (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(scene.unreduced, nullptr);
  takeOut(scene, items("[other]"));
  EXPECT_EQ(scene.unreduced->absent, (std::vector<std::string>{"other"}));
}

// What decides how the rest is traced.
TEST(Without, TheWholeSceneIsRemembered) {
  Scene scene = twoCopies("second", 900);
  const Box before = scene.bounds();
  const std::uint64_t triangles = scene.placedTriangles();
  takeOut(scene, items("[3]"));
  takeOut(scene, items("[second]"));
  EXPECT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(length(scene.bounds().high - before.high), 0);
  EXPECT_EQ(scene.unreduced->placedTriangles, triangles);
  EXPECT_EQ(scene.unreduced->copies.size(), scene.meshes.size());
  EXPECT_EQ(scene.unreduced->copies[0], 2u);
}

}  // namespace
}  // namespace scanmill
