// Objects that move while the sensor rotates: every beam meets them where they are when it fires.

#include "base/path.h"
#include "scene/scene.h"
#include "tests/core/methods/trace.h"
#include "tests/support/same_hits.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

constexpr double kPeriod = 0.1;  // s

Shot revolution(std::shared_ptr<const BeamTable> beams, double time) {
  Shot shot = shotAt(std::move(beams));
  shot.time = time;
  shot.duration = kPeriod;
  return shot;
}

// Beams that look along x one after the other, all through a revolution.
std::shared_ptr<BeamTable> stare(std::size_t count) {
  auto beams = beamsOf(std::vector<Vec3d>(count, {1, 0, 0}));
  beams->time.clear();
  for (std::size_t i = 0; i < count; ++i) {
    beams->time.push_back(static_cast<float>(kPeriod * static_cast<double>(i) / static_cast<double>(count)));
  }
  return beams;
}

Scene movingBox(const std::shared_ptr<const Movement>& movement, const Affine& place) {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 200, 200, 4);
  builder.place(builder.addMesh(ground), at(0, 0, -2), "ground");
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {2, 2, 2});
  builder.place(builder.addMesh(box), place, "box", {}, movement);
  return builder.finish();
}

TEST(MovingObjects, ComeNearerBeamByBeam) {
  const Scene scene = movingBox(std::make_shared<Movement>(Vec3d{-20, 0, 0}), at(60, 0, 0));
  const auto beams = stare(512);
  const auto method = rayTracing(scene);
  for (const double time : {0.0, 0.7, 1.3}) {
    const Hits hits = traced(*method, revolution(beams, time));
    for (std::size_t i = 0; i < beams->size(); ++i) {
      const double at = time + double{beams->time[i]};
      ASSERT_NEAR(double{hits.range[i]}, 59 - 20 * at, 1e-5) << time;
      ASSERT_EQ(hits.instance[i], 1u);
    }
  }
}

// A wall that turns by 40 degrees a second meets the beams at its angle of their moment.
TEST(MovingObjects, TurnWithTheirNormals) {
  const double radius = 30;
  std::vector<Vec3d> circle;
  for (int k = 0; k <= 32; ++k)
    circle.push_back({radius * std::sin(k * 0.05), radius - radius * std::cos(k * 0.05), 0});
  const double speed = radius * radians(40);
  const auto path = std::make_shared<const Path>(circle);
  const Scene scene = movingBox(std::make_shared<Movement>(path, 5.0, speed), at(10, -5, 0));
  const auto beams = stare(64);
  const Hits hits = traced(scene, revolution(beams, 0.2));
  int met = 0;
  for (std::size_t i = 0; i < beams->size(); ++i) {
    if (hits.instance[i] != 1) continue;
    ++met;
    const double turned = (5 + speed * (0.2 + double{beams->time[i]})) / radius;
    EXPECT_NEAR(double{hits.incidence[i]}, std::max(std::cos(turned), std::sin(turned)), 1e-3);
  }
  EXPECT_GT(met, 10);
}

// What moves with the sensor looks as if both stood still.
TEST(MovingObjects, StandStillBesideASensorThatMovesAlong) {
  const Vec3d velocity{12, 3, 0};
  const Scene moving = movingBox(std::make_shared<Movement>(velocity), at(8, 1, 0));
  const Scene still = movingBox(nullptr, at(8, 1, 0));
  const auto beams = spinning(8, 256, -20, 5, 60);
  Shot shot = revolution(beams, 0);
  shot.worldFromSensor.clear();
  for (std::uint32_t column = 0; column < 256; ++column) {
    shot.worldFromSensor.push_back({{}, velocity * double{beams->time[column]}});
  }
  const Hits along = traced(moving, shot);
  const Hits fixed = traced(still, shotAt(beams));
  for (std::size_t i = 0; i < beams->size(); ++i) {
    ASSERT_EQ(along.instance[i], fixed.instance[i]) << i;
    if (!fixed.hit(i)) continue;
    ASSERT_NEAR(double{along.range[i]}, double{fixed.range[i]}, 2e-5 * double{fixed.range[i]} + 1e-5);
  }
}

TEST(MovingObjects, WithoutADurationStandWhereTheyAreAtTheTime) {
  const Scene scene = movingBox(std::make_shared<Movement>(Vec3d{-20, 0, 0}), at(60, 0, 0));
  Shot shot = revolution(stare(32), 1.5);
  shot.duration = 0;
  const Hits hits = traced(scene, shot);
  for (const float range : hits.range) EXPECT_NEAR(double{range}, 59 - 30, 1e-5);
}

// No movement, no cost: the same hits as ever, bit by bit, whatever the time.
TEST(MovingObjects, LeaveStillScenesAsTheyAre) {
  const Scene scene = movingBox(nullptr, at(8, 1, 0));
  const auto beams = spinning(8, 256, -20, 5);
  expectSameHits(traced(scene, revolution(beams, 3)), traced(scene, shotAt(beams)));
}

// Of an animated object each revolution meets the mesh of its middle.
TEST(MovingObjects, TakeTheMeshOfTheMoment) {
  SceneBuilder builder = testBuilder();
  std::vector<std::uint32_t> meshes;
  for (const double half : {1.0, 2.0, 3.0}) {
    Mesh box = meshOf(builder, "thing");
    appendBox(box, 0, {}, {2 * half, 2, 2});
    meshes.push_back(builder.addMesh(box));
  }
  builder.place(meshes[0], at(20, 0, 0), "box", {}, nullptr,
                std::make_shared<Animation>(Animation{meshes, 3 * kPeriod, 100}));
  const Scene scene = builder.finish();
  const auto method = rayTracing(scene, "{}");
  const auto beams = stare(16);
  for (int k = 1; k < 8; ++k) {
    const Hits hits = traced(*method, revolution(beams, (k - 0.5) * kPeriod));
    for (std::size_t i = 0; i < beams->size(); ++i) {
      ASSERT_NEAR(double{hits.range[i]}, 19 - k % 3, 1e-6) << k;
      ASSERT_EQ(hits.instance[i], 1u);
    }
  }
}

}  // namespace
}  // namespace scanmill
