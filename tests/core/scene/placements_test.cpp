#include "scene/placements.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/scene.h"

namespace scanmill {
namespace {

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
