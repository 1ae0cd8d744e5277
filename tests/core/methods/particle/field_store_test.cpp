#include "methods/particle/field_store.h"

#include <vector>

#include "base/parallel.h"
#include "tests/support/on_threads.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// A ground 600 m long with a ball every ten metres.
Scene alley() {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "ground");
  appendPlane(mesh, 0, at(0, 0, -1), 600, 40, 20);
  builder.place(builder.addMesh(mesh), {}, "ground");
  Mesh ball = meshOf(builder, "thing");
  appendSphere(ball, 0, {}, 0.7, 8);
  const std::uint32_t number = builder.addMesh(ball);
  for (int x = -290; x <= 290; x += 10) builder.place(number, at(x, x % 20 == 0 ? 3 : -3, -0.3), "ball");
  return builder.finish();
}

ParticleOptions smallField() {
  ParticleOptions options;
  options.voxel = 0.2;
  options.voxels = 32;
  options.levels = 3;
  options.refine = ParticleOptions::Refine::None;
  return options;
}

constexpr double kRange = 20;  // m

// Returns the nearest triangles to places around the sensor.
std::vector<std::uint32_t> trianglesAt(const SensorField& place) {
  std::vector<std::uint32_t> triangles;
  for (int i = 0; i < 500; ++i) {
    const double angle = 0.7 * i;
    const double travelled = 0.02 * i;
    const Vec3f q{static_cast<float>(travelled * std::cos(angle) / 0.2),
                  static_cast<float>(travelled * std::sin(angle) / 0.2), static_cast<float>(-0.01 * i)};
    triangles.push_back(triangleAt(*place.field, q));
  }
  return triangles;
}

// Threads work on drives of their own: each field comes from the one before in its drive, though others came between.
TEST(FieldStore, DrivesDoNotDisturbEachOther) {
  const Scene scene = alley();
  const ThreadLimit limit(2);
  const FieldStore store(scene, smallField());
  StageClock clock;
  std::vector<std::shared_ptr<const DistanceField>> last(2);
  std::size_t kept = 0;
  constexpr int kSteps = 12;
  for (int step = 0; step < kSteps; ++step) {
    for (std::size_t drive = 0; drive < 2; ++drive) {
      const Vec3d sensor{(drive == 0 ? -200.0 : 150.0) + step, 0, 0.5};
      const SensorField place = store.around(sensor, kRange, clock);
      EXPECT_EQ(trianglesAt(place), trianglesAt(FieldStore(scene, smallField()).around(sensor, kRange, clock)));
      if (last[drive] != nullptr && place.field->pool == last[drive]->pool) ++kept;
      last[drive] = place.field;
    }
  }
  EXPECT_GT(kept, kSteps / 2u);
  EXPECT_NE(last[0]->pool, last[1]->pool);
}

TEST(FieldStore, OldDrivesAreForgotten) {
  const Scene scene = alley();
  const ThreadLimit limit(2);
  const FieldStore store(scene, smallField());
  StageClock clock;
  std::vector<std::weak_ptr<const DistanceField>> fields;
  for (int k = 0; k < 10; ++k) fields.push_back(store.around({-290.0 + 60 * k, 0, 0.5}, kRange, clock).field);
  std::size_t alive = 0;
  for (const auto& field : fields) alive += field.expired() ? 0 : 1;
  EXPECT_EQ(alive, 3u) << "and one that is being built";
  EXPECT_FALSE(fields.back().expired());
}

// All that wait for a field get it, and help with those that others wait for.
TEST(FieldStore, ServesSeveralThreads) {
  const Scene scene = alley();
  std::vector<std::vector<std::uint32_t>> expected;
  StageClock ignored;
  const auto sensorAt = [](int k) { return Vec3d{-100.0 + 2 * k, 0, 0.5}; };
  constexpr int kPlaces = 6;
  for (int k = 0; k < kPlaces; ++k) {
    expected.push_back(trianglesAt(FieldStore(scene, smallField()).around(sensorAt(k), kRange, ignored)));
  }
  const FieldStore store(scene, smallField());
  StageClock clock;
  onThreads(4, [&](std::size_t thread) {
    const int t = static_cast<int>(thread);
    for (int i = 0; i < 2 * kPlaces; ++i) {
      const int k = (i * (t + 1) + t) % kPlaces;
      EXPECT_EQ(trianglesAt(store.around(sensorAt(k), kRange, clock)), expected[static_cast<std::size_t>(k)]);
    }
  });
  EXPECT_EQ(clock.seconds().count("field_build"), 1u);
}

}  // namespace
}  // namespace scanmill
