#include "base/path.h"
#include "scene/placements.h"
#include "scene/scene.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

std::shared_ptr<const Movement> along(const std::vector<Vec3d>& waypoints, double speed, double start = 0) {
  return std::make_shared<Movement>(std::make_shared<const Path>(waypoints), start, speed);
}

TEST(Movement, KeepsItsVelocity) {
  const Movement m(Vec3d{3, -4, 1});
  EXPECT_EQ(m.at(0), Pose{});
  EXPECT_EQ(m.at(2).translation, (Vec3d{6, -8, 2}));
  EXPECT_EQ(m.at(2).rotation, Quat{});
  EXPECT_EQ(m.at(-5), m.at(0));
}

TEST(Movement, FollowsWaypointsAtItsSpeedAndStopsAtTheEnd) {
  const auto m = along({{0, 0, 0}, {0, 50, 0}, {0, 100, 0}}, 5, 10);
  EXPECT_NEAR(length(m->at(0).translation - Vec3d{0, 10, 0}), 0, 1e-9);
  EXPECT_NEAR(length(m->at(4).translation - Vec3d{0, 30, 0}), 0, 1e-9);
  EXPECT_NEAR(length(m->at(1e6).translation - Vec3d{0, 100, 0}), 0, 1e-9);
  const Vec3d ahead = toMatrix(m->at(4).rotation) * Vec3d{1, 0, 0};
  EXPECT_NEAR(length(ahead - Vec3d{0, 1, 0}), 0, 1e-9);
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
  builder.place(builder.addMesh(box), place, "box", {}, along({{0, 0, 0}, {30, 0, 0}, {40, 20, 0}}, 10));
  const Scene scene = builder.finish();
  EXPECT_TRUE(scene.moves());
  const Instance& instance = scene.instances.front();
  EXPECT_NEAR(length(instance.worldFromMeshAt(0).translation - instance.worldFromMesh.translation), 0, 1e-12);
  const Affine later = instance.worldFromMeshAt(3.5);
  EXPECT_GT(length(later.translation - instance.worldFromMesh.translation), 30);
  EXPECT_NEAR(determinant(later.linear), determinant(place.linear), 1e-9);
  EXPECT_NEAR(length(later.linear.y), 2, 1e-9);
}

TEST(Movement, KnowsWhetherItMoves) {
  EXPECT_TRUE(Movement(Vec3d{3, 0, 0}).moves());
  EXPECT_FALSE(Movement(Vec3d{0, 0, 0}).moves());
  EXPECT_TRUE(along({{0, 0, 0}, {10, 0, 0}}, 5)->moves());
  EXPECT_FALSE(along({{0, 0, 0}, {10, 0, 0}}, 5, 10)->moves());
}

TEST(Animation, ShowsEachMeshForItsPartOfThePeriodUntilItEnds) {
  const Animation a{{7, 8, 9, 4}, 2, 5.2};
  EXPECT_EQ(a.at(0), 7u);
  EXPECT_EQ(a.at(0.24), 7u);
  EXPECT_EQ(a.at(0.26), 8u);
  EXPECT_EQ(a.at(0.74), 8u);
  EXPECT_EQ(a.at(1.5), 4u);
  EXPECT_EQ(a.at(1.76), 7u);
  EXPECT_EQ(a.at(2.1), 7u);
  EXPECT_EQ(a.at(4.6), 8u);
  EXPECT_EQ(a.at(5.2), a.at(1000)) << "it has ended";
  EXPECT_EQ(a.at(-3), 7u);
}

TEST(Scene, StandsStillAsItWasAtATime) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {2, 2, 2});
  const std::uint32_t first = builder.addMesh(box);
  appendBox(box, 0, at(0, 0, 3), {1, 1, 1});
  const std::uint32_t second = builder.addMesh(box);
  builder.place(first, at(0, 1, 0), "thing", {}, std::make_shared<Movement>(Vec3d{3, 0, 0}),
                std::make_shared<Animation>(Animation{{first, second}, 2, 10}));
  Scene scene = builder.finish();
  EXPECT_TRUE(scene.moves());
  standStill(scene, 3);
  EXPECT_FALSE(scene.moves());
  EXPECT_EQ(scene.instances[0].worldFromMesh.translation, (Vec3d{9, 1, 0}));
  EXPECT_EQ(scene.instances[0].mesh, second);
  EXPECT_EQ(scene.instances[0].worldFromMeshAt(50).translation, (Vec3d{9, 1, 0}));
}

void expectEqual(const Affine& a, const Affine& b) {
  EXPECT_LT(length(a.translation - b.translation), 1e-12);
  for (const auto axis : {&Mat3::x, &Mat3::y, &Mat3::z}) EXPECT_LT(length(a.linear.*axis - b.linear.*axis), 1e-12);
}

TEST(Placements, MoveAtConstantVelocityAndTurnAboutTheOrigin) {
  const RigidMotion p{
      .worldFromMesh = {Mat3::scale({2, 2, 2}), {1, 2, 3}}, .velocity = {3, 0, -1}, .turning = {0, 0, kPi}};
  expectEqual(p.at(0), p.worldFromMesh);
  expectEqual(p.at(0.5), {{{0, 2, 0}, {-2, 0, 0}, {0, 0, 2}}, {2.5, 2, 2.5}});
  EXPECT_TRUE(p.moves());
  EXPECT_FALSE((RigidMotion{.worldFromMesh = p.worldFromMesh}.moves()));
}

// Half a turn and another half are the turn; the place before is reached by time that is negative.
TEST(Placements, TurnsAddUp) {
  const RigidMotion p{.worldFromMesh = {}, .velocity = {1, 2, 3}, .turning = {0.3, -0.2, 0.9}};
  const RigidMotion later{.worldFromMesh = p.at(0.7), .velocity = p.velocity, .turning = p.turning};
  expectEqual(later.at(0.6), p.at(1.3));
  expectEqual(later.at(-0.7), p.worldFromMesh);
}

TEST(Placements, ReplaceThePlaceOfTheSceneForOneInstance) {
  Instance instance;
  instance.worldFromMesh.translation = {5, 0, 0};
  Placements placed(10);
  placed.set(3, {.worldFromMesh = {{}, {0, 1, 0}}, .velocity = {0, 2, 0}});
  expectEqual(worldFromMeshAt(instance, 3, &placed, 11), {{}, {0, 3, 0}});
  expectEqual(worldFromMeshAt(instance, 2, &placed, 11), instance.worldFromMesh);
  expectEqual(worldFromMeshAt(instance, 3, nullptr, 11), instance.worldFromMesh);
}

TEST(Placements, RigidPartsKeepScaleAndMirroringOutOfThePose) {
  const Affine turn{toMatrix(fromYawPitchRoll(0.4, -0.3, 1.1)), {1, -2, 3}};
  expectEqual(rigidPartOf(turn), turn);
  for (const Vec3d& scale : {Vec3d{2, 3, 0.5}, Vec3d{1, 1, -1}}) {
    const Affine rigid = rigidPartOf({turn.linear * Mat3::scale(scale), turn.translation});
    expectEqual(rigid, turn);
    EXPECT_NEAR(determinant(rigid.linear), 1, 1e-12);
  }
}

}  // namespace
}  // namespace scanmill
