#include "scene/thing_boxes.h"

#include <map>

#include "base/path.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::ElementsAre;

Affine turned(double yaw, double pitch, double roll, const Vec3d& scale, const Vec3d& place) {
  return {toMatrix(fromYawPitchRoll(yaw, pitch, roll)) * Mat3::scale(scale), place};
}

Mesh boxMesh(SceneBuilder& builder, const Vec3d& size, const Affine& place = {}) {
  Mesh mesh = meshOf(builder, "thing");
  appendBox(mesh, 0, place, size);
  return mesh;
}

void expectNear(const Vec3d& a, const Vec3d& b, double error = 1e-6) {
  EXPECT_LT(length(a - b), error) << a.x << " " << a.y << " " << a.z << " for " << b.x << " " << b.y << " " << b.z;
}

// Every corner of the thing's triangles lies in the box, and each of its six faces is touched.
void expectTight(const Scene& scene, const ThingBoxes& boxes, std::size_t thing, double time, double error) {
  const OrientedBox box = boxes.at(thing, time);
  const Pose boxFromWorld = inverse(box.worldFromBox);
  Box found;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.meshAt(time)];
    const Affine worldFromMesh = instance.worldFromMeshAt(time);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (instanceId(instance, mesh.surfaces[mesh.surfaceOf[t]]) != boxes.things()[thing].id) continue;
      for (const std::uint32_t corner : mesh.triangles[t]) {
        found.add(boxFromWorld * (worldFromMesh * Vec3d(mesh.positions[corner])));
      }
    }
  }
  expectNear(found.low, box.size * -0.5, error);
  expectNear(found.high, box.size * 0.5, error);
}

TEST(ThingBoxes, HaveTheAxesOfThePlacedObject) {
  SceneBuilder builder = testBuilder();
  const std::uint32_t mesh = builder.addMesh(boxMesh(builder, {4, 2, 1.5}, at(0, 0, 0.75)));
  builder.place(mesh, turned(0.5, 0.2, -0.1, {1, 1, 1}, {10, 20, 3}), "car");
  builder.place(mesh, turned(-2, 0, 0, {1, -2, 3}, {500000, 5400000, 300}), "mirrored");
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 50, 50);
  builder.place(builder.addMesh(ground), {}, "ground");
  const Scene scene = builder.finish();
  const ThingBoxes boxes(scene);
  ASSERT_EQ(boxes.things().size(), 2u) << "what is no thing has no box";
  EXPECT_EQ(boxes.things()[0].id, 1u);
  EXPECT_EQ(boxes.things()[0].name, "car");
  EXPECT_EQ(boxes.things()[0].semantic, 2);
  EXPECT_TRUE(boxes.things()[0].headingKnown);
  EXPECT_FALSE(boxes.things()[0].moves);
  const OrientedBox car = boxes.at(0, 0);
  const Quat rotation = fromYawPitchRoll(0.5, 0.2, -0.1);
  expectNear(car.size, {4, 2, 1.5});
  expectNear(car.worldFromBox.translation, Vec3d{10, 20, 3} + toMatrix(rotation) * Vec3d{0, 0, 0.75});
  EXPECT_NEAR(headingOf(car.worldFromBox.rotation), 0.5, 1e-9);
  const OrientedBox mirrored = boxes.at(1, 0);
  expectNear(mirrored.size, {4, 4, 4.5});
  EXPECT_NEAR(headingOf(mirrored.worldFromBox.rotation), -2, 1e-9);
  EXPECT_EQ(boxes.velocity(0, 1), Vec3d());
  for (const std::size_t thing : {0u, 1u}) expectTight(scene, boxes, thing, 0, 1e-6);
}

// Only the axes change: the box is about the same triangles.
TEST(ThingBoxes, FaceTheWayThatTheModelDoes) {
  SceneBuilder builder = testBuilder();
  const std::uint32_t mesh = builder.addMesh(boxMesh(builder, {2, 4, 1.5}, at(0.5, 0, 0.75)));
  builder.place(mesh, turned(0.5, 0, 0, {1, 1, 1}, {10, 20, 3}), "car").facing = -kPi / 2;
  const Scene scene = builder.finish();
  const ThingBoxes boxes(scene);
  EXPECT_TRUE(boxes.things()[0].headingKnown);
  const OrientedBox box = boxes.at(0, 0);
  expectNear(box.size, {4, 2, 1.5});
  expectNear(toMatrix(box.worldFromBox.rotation).x, {std::cos(0.5 - kPi / 2), std::sin(0.5 - kPi / 2), 0});
  expectTight(scene, boxes, 0, 0, 1e-5);
}

TEST(ThingBoxes, OfSeveralThingsInAFileCoverTheLeastGround) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "thing");
  mesh.surfaces.push_back(mesh.surfaces.front());
  mesh.surfaces[0].object = 1;
  mesh.surfaces[1].object = 2;
  mesh.surfaces[0].node = "house";
  mesh.surfaces[1].node = "tower";
  appendBox(mesh, 0, {toMatrix(fromYawPitchRoll(0.4, 0, 0)), {5, 0, 2}}, {3, 8, 4});
  appendCylinder(mesh, 1, at(-20, 0, 5), 2, 2, 10, 4);
  builder.place(builder.addMesh(mesh), turned(0.3, 0, 0, {1, 1, 1}, {1, 2, 3}), "village");
  const Scene scene = builder.finish();
  const ThingBoxes boxes(scene);
  ASSERT_EQ(boxes.things().size(), 2u);
  EXPECT_THAT(boxes.things()[0].parts, ElementsAre("house"));
  EXPECT_FALSE(boxes.things()[0].headingKnown);
  const OrientedBox house = boxes.at(0, 0);
  expectNear(house.size, {8, 3, 4}, 1e-5);
  EXPECT_NEAR(std::abs(std::sin(headingOf(house.worldFromBox.rotation) - (0.7 + kPi / 2))), 0, 1e-6);
  const double side = 2 * std::sqrt(2.0);
  expectNear(boxes.at(1, 0).size, {side, side, 10}, 1e-5);
  for (const std::size_t thing : {0u, 1u}) expectTight(scene, boxes, thing, 0, 1e-5);
}

TEST(ThingBoxes, MoveWithTheirThings) {
  SceneBuilder builder = testBuilder();
  const auto path = std::make_shared<const Path>(Path::lines({{0, 0, 0}, {50, 0, 0}, {50, 50, 0}}, 2));
  const auto drive = std::make_shared<const Movement>(path, 0, 5);
  const std::uint32_t body = builder.addMesh(boxMesh(builder, {4, 2, 1}));
  const std::uint32_t trailer = builder.addMesh(boxMesh(builder, {1, 1, 1}));
  builder.place(body, at(0, 0, 1), "body", {}, drive, nullptr, "lorry");
  builder.place(trailer, at(-4, 0, 1), "trailer", {}, drive, nullptr, "lorry");
  builder.place(body, at(0, 9, 1), "other", {}, std::make_shared<const Movement>(Vec3d{0, 0, 2}));
  const Scene scene = builder.finish();
  const ThingBoxes boxes(scene);
  ASSERT_EQ(boxes.things().size(), 2u);
  EXPECT_TRUE(boxes.things()[0].moves);
  EXPECT_EQ(boxes.things()[0].name, "body");
  expectNear(boxes.at(0, 0).size, {6.5, 2, 1});
  expectNear(boxes.at(0, 4).size, {6.5, 2, 1});
  expectNear(boxes.at(0, 4).worldFromBox.translation - boxes.at(0, 0).worldFromBox.translation, {20, 0, 0}, 0.5);
  EXPECT_NEAR(headingOf(boxes.at(0, 18).worldFromBox.rotation), kPi / 2, 1e-3);
  expectNear(boxes.velocity(0, 4), {5, 0, 0}, 0.2);
  expectNear(boxes.velocity(0, 18), {0, 5, 0}, 0.2);
  expectNear(boxes.velocity(1, 3), {0, 0, 2}, 1e-9);
  expectNear(boxes.at(1, 3).worldFromBox.translation, {0, 9, 7}, 1e-9);
  for (const double time : {0.0, 4.0, 10.0, 100.0}) {
    for (const std::size_t thing : {0u, 1u}) expectTight(scene, boxes, thing, time, 1e-6);
  }
}

TEST(ThingBoxes, OfWhatChangesItsShapeAreThoseOfTheMoment) {
  SceneBuilder builder = testBuilder();
  const std::uint32_t narrow = builder.addMesh(boxMesh(builder, {1, 1, 1}));
  const std::uint32_t wide = builder.addMesh(boxMesh(builder, {3, 1, 1}));
  const auto stride = std::make_shared<const Animation>(Animation{{narrow, wide}, 1, 10});
  builder.place(narrow, at(5, 0, 0), "walker", {}, std::make_shared<const Movement>(Vec3d{1, 0, 0}), stride);
  const Scene scene = builder.finish();
  const ThingBoxes boxes(scene);
  std::map<double, int> lengths;
  for (double time = 0; time < 3; time += 0.05) {
    expectTight(scene, boxes, 0, time, 1e-6);
    ++lengths[std::round(boxes.at(0, time).size.x)];
  }
  EXPECT_EQ(lengths.size(), 2u);
  EXPECT_TRUE(boxes.things()[0].moves);
}

}  // namespace
}  // namespace scanmill
