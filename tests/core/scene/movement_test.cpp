#include "scene/movement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

std::shared_ptr<const Movement> movement(const std::string& yaml) {
  return readMovement(parseYaml(yaml, "scene.yaml"));
}

TEST(Movement, KeepsItsVelocity) {
  const auto m = movement("{velocity: [3, -4, 1]}");
  EXPECT_EQ(m->at(0), Pose{});
  EXPECT_EQ(m->at(2).translation, (Vec3d{6, -8, 2}));
  EXPECT_EQ(m->at(2).rotation, Quat{});
  EXPECT_EQ(m->at(-5), m->at(0));
}

TEST(Movement, FollowsWaypointsAtItsSpeedAndStopsAtTheEnd) {
  const auto m = movement("{waypoints: [[0, 0, 0], [0, 50, 0], [0, 100, 0]], speed: 5, start: 10}");
  EXPECT_NEAR(length(m->at(0).translation - Vec3d{0, 10, 0}), 0, 1e-9);
  EXPECT_NEAR(length(m->at(4).translation - Vec3d{0, 30, 0}), 0, 1e-9);
  EXPECT_NEAR(length(m->at(1e6).translation - Vec3d{0, 100, 0}), 0, 1e-9);
  const Vec3d ahead = toMatrix(m->at(4).rotation) * Vec3d{1, 0, 0};
  EXPECT_NEAR(length(ahead - Vec3d{0, 1, 0}), 0, 1e-9);
}

TEST(Movement, StandsAtTheEndFromTheStart) {
  const auto m = movement("{waypoints: [[0, 0, 0], [10, 0, 0]], speed: 5, start: 10}");
  EXPECT_NEAR(m->at(3).translation.x, 10, 1e-9);
}

TEST(Movement, FollowsATableOfDistances) {
  const auto path = std::make_shared<const Path>(std::vector<Vec3d>{{0, 0, 0}, {100, 0, 0}});
  const Movement m(path, {0, 1, 4, 4}, 0.5);
  EXPECT_NEAR(m.at(0.25).translation.x, 0.5, 1e-9);
  EXPECT_NEAR(m.at(0.75).translation.x, 2.5, 1e-9);
  EXPECT_NEAR(m.at(9).translation.x, 4, 1e-9);
}

// A mesh that is turned and stretched keeps its shape on a bend.
TEST(Movement, InstancesMoveRigidly) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {1, 2, 3});
  const Affine place{Mat3::scale({1, 2, 0.5}), {0.5, 0, 1}};
  builder.place(builder.addMesh(box), place, "box", {},
                movement("{waypoints: [[0, 0, 0], [30, 0, 0], [40, 20, 0]], speed: 10}"));
  const Scene scene = builder.finish();
  EXPECT_TRUE(scene.moves());
  const Instance& instance = scene.instances.front();
  EXPECT_NEAR(length(instance.worldFromMeshAt(0).translation - instance.worldFromMesh.translation), 0, 1e-12);
  const Affine later = instance.worldFromMeshAt(3.5);
  EXPECT_GT(length(later.translation - instance.worldFromMesh.translation), 30);
  EXPECT_NEAR(determinant(later.linear), determinant(place.linear), 1e-9);
  EXPECT_NEAR(length(later.linear.y), 2, 1e-9);
}

TEST(Movement, RefusesWhatItDoesNotKnow) {
  const auto refusal = [](const std::string& yaml) { return messageOf([&] { movement(yaml); }); };
  EXPECT_THAT(refusal("{}"), HasSubstr("velocity"));
  EXPECT_THAT(refusal("{velocity: [1, 0, 0], speed: 3}"), HasSubstr("speed is for waypoints"));
  EXPECT_THAT(refusal("{velocity: [400, 0, 0]}"), HasSubstr("300 m/s"));
  EXPECT_THAT(refusal("{waypoints: [[0, 0, 0], [1, 0, 0]]}"), HasSubstr("speed"));
  EXPECT_THAT(refusal("{waypoints: [[0, 0, 0], [1, 0, 0]], speed: 1, start: 2}"), HasSubstr("start"));
  EXPECT_THAT(refusal("{waypoint: [[0, 0, 0], [1, 0, 0]], speed: 1}"), HasSubstr("waypoints"));
}

}  // namespace
}  // namespace scanmill
