#include "base/path.h"
#include "sense/sense.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

Scene sceneOf(std::shared_ptr<const Movement> movement) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {2, 2, 2});
  const std::uint32_t mesh = builder.addMesh(box);
  builder.place(mesh, at(10, 0, 0), "still");
  builder.place(mesh, {}, "moving", {}, std::move(movement));
  return builder.finish();
}

Shot shotAtTime(double time, double duration) {
  Shot shot;
  shot.time = time;
  shot.duration = duration;
  return shot;
}

// Steps of an angle (rad) along a circle around the origin.
std::shared_ptr<const Path> arc(double radius, double step, int steps) {
  std::vector<Vec3d> places;
  for (int k = 0; k <= steps; ++k) places.push_back(Vec3d{std::cos(step * k), std::sin(step * k), 0} * radius);
  return std::make_shared<const Path>(places);
}

TEST(InstanceMotions, AreTheVelocityOfWhatGoesStraightOn) {
  const Scene scene = sceneOf(std::make_shared<Movement>(Vec3d{3, -4, 1}));
  for (const double duration : {0.0, 0.1, 1.0}) {
    const InstanceMotions motions(scene, shotAtTime(2, duration));
    EXPECT_NEAR(length(motions.velocity(2, {7, -8, 2}) - Vec3d{3, -4, 1}), 0, 1e-9);
    EXPECT_EQ(motions.velocity(1, {10, 0, 0}), Vec3d{}) << "it stands";
    EXPECT_EQ(motions.velocity(0, {1, 2, 3}), Vec3d{}) << "it is no thing";
  }
}

// On a circle of radius r at a speed v every place of a rigid body moves at v / r times its distance from the centre,
// at right angles to it.
TEST(InstanceMotions, TurnWithWhatTurns) {
  constexpr double kRadius = 40;
  constexpr double kSpeed = 8;
  const auto path = arc(kRadius, radians(2.0), 90);
  const Scene scene = sceneOf(std::make_shared<Movement>(path, 0, kSpeed));
  for (const double time : {1.0, 5.0, 9.0}) {
    const InstanceMotions motions(scene, shotAtTime(time, 0.1));
    const Vec3d middle = path->pose((time + 0.05) * kSpeed).translation;
    for (const Vec3d& place : {middle, middle + Vec3d{2, 1, 0.5}, middle + Vec3d{-1, 2, -1}}) {
      const Vec3d wanted = Vec3d{-place.y, place.x, 0} * (kSpeed / kRadius);
      EXPECT_NEAR(length(motions.velocity(2, place) - wanted), 0, 0.02 * kSpeed) << time;
    }
  }
}

// Carried by the thing itself: exact on a circle too, where velocity times time is not.
TEST(InstanceMotions, FlowLeadsToTheSamePlaceOfTheSurface) {
  constexpr double kRadius = 20;
  constexpr double kSpeed = 10;
  const auto path = arc(kRadius, radians(0.5), 720);
  const Scene scene = sceneOf(std::make_shared<Movement>(path, 0, kSpeed));
  Shot shot = shotAtTime(1, 0.1);
  shot.untilNext = 0.5;
  const InstanceMotions motions(scene, shot);
  for (const double time : {0.0, 0.04, 0.1}) {
    const Pose now = path->pose((1 + time) * kSpeed);
    const Pose then = path->pose((1.5 + time) * kSpeed);
    for (const Vec3d& own : {Vec3d{1, 0.5, 0.2}, Vec3d{-1, -1, 1}}) {
      EXPECT_NEAR(length(now * own + motions.flow(2, 0, now * own, time) - then * own), 0, 1e-9);
    }
  }
  EXPECT_EQ(motions.flow(1, 0, {10, 0, 0}, 0), Vec3d{}) << "it stands";
  EXPECT_EQ(motions.flow(0, 0, {10, 0, 0}, 0), Vec3d{}) << "it is no thing";
}

// What an animation does to a triangle it does to the places on it.
TEST(InstanceMotions, FlowFollowsTheShape) {
  SceneBuilder builder = testBuilder();
  std::vector<std::uint32_t> moments;
  for (const float height : {1.0f, 3.0f}) {
    Mesh mesh = meshOf(builder, "thing");
    mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, height}};
    mesh.triangles = {{0, 1, 2}};
    mesh.surfaceOf = {0};
    moments.push_back(builder.addMesh(mesh));
  }
  builder.place(moments[0], at(5, 0, 0), "grows", {}, nullptr,
                std::make_shared<const Animation>(Animation{moments, 2, 100}));
  const Scene scene = builder.finish();
  Shot shot = shotAtTime(0.2, 0);
  shot.untilNext = 1;
  const InstanceMotions motions(scene, shot);
  EXPECT_NEAR(length(motions.flow(1, 0, {5, 2, 1}, 0) - Vec3d{0, 0, 2}), 0, 1e-6) << "the corner that rises";
  EXPECT_NEAR(length(motions.flow(1, 0, {5, 1, 0.5}, 0) - Vec3d{0, 0, 1}), 0, 1e-6);
  EXPECT_NEAR(length(motions.flow(1, 0, {6, 0, 0}, 0)), 0, 1e-6);
}

TEST(InstanceMotions, HaveTheClassesOfWhatMoves) {
  Scene scene = sceneOf(std::make_shared<Movement>(Vec3d{1, 0, 0}));
  const std::uint16_t still = scene.meshes[0].surfaces[0].semantic;
  EXPECT_FALSE(InstanceMotions(scene, shotAtTime(0, 0.1)).haveMovingClasses());
  EXPECT_EQ(InstanceMotions(scene, shotAtTime(0, 0.1)).classOf(still, 2), still);
  scene.ontology.classes.push_back({.id = 900, .name = "moving-thing", .color = {}, .thing = true, .aliases = {}});
  scene.ontology.classes.back().movingOf = still;
  const InstanceMotions motions(scene, shotAtTime(0, 0.1));
  EXPECT_TRUE(motions.haveMovingClasses());
  EXPECT_EQ(motions.classOf(still, 2), 900);
  EXPECT_EQ(motions.classOf(still, 1), still);
  EXPECT_EQ(motions.classOf(7, 2), 7) << "a class of what moves not";
  standStill(scene, 3);
  const InstanceMotions none(scene, shotAtTime(0, 0.1));
  EXPECT_FALSE(none.haveMovingClasses());
  EXPECT_EQ(none.velocity(2, {}), Vec3d{});
}

}  // namespace
}  // namespace scanmill
