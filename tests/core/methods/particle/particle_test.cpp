// The particle method as a whole, against closed forms and against ray tracing.

#include "methods/particle/particle.h"

#include <cstdlib>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/random.h"
#include "tests/core/methods/trace.h"
#include "tests/support/directions.h"
#include "tests/support/gl.h"
#include "tests/support/same_hits.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// On the processor where nothing else is said.
std::unique_ptr<Method> particle(const Scene& scene, const std::string& options = "") {
  const bool backend = options.find("backend") != std::string::npos;
  return methodOf("particle", scene, "{" + std::string(backend ? "" : "backend: cpu, ") + options + "}");
}

Hits flown(const Scene& scene, const Shot& shot, const std::string& options = "") {
  return traced(*particle(scene, options), shot);
}

Scene groundScene(double depth) {
  return flatGround({0, 0, -depth}, 400, 8);
}

struct TurnedBox {
  Mat3 worldFromBox = toMatrix(fromYawPitchRoll(0.4, 0.3, 0.2));
  Vec3d half{5, 3.5, 2};
  Vec3d centre;

  Scene scene() const {
    const auto fill = [&](Mesh& walls) { appendBox(walls, 0, {}, half * 2.0); };
    return oneMeshScene("thing", fill, {worldFromBox, centre});
  }
  Vec3d inBox(const Vec3d& point) const { return transposed(worldFromBox) * (point - centre); }
  // To the wall that is nearest, from inside or outside (m).
  double toWalls(const Vec3d& point) const {
    const Vec3d p = inBox(point);
    const Vec3d beyond{std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z};
    const Vec3d out{std::max(beyond.x, 0.0), std::max(beyond.y, 0.0), std::max(beyond.z, 0.0)};
    const double within = std::max({beyond.x, beyond.y, beyond.z});
    return within > 0 ? length(out) : -within;
  }
};

// Ten million beams of each kind, from ten places in rooms turned at random. Sanitized builds fly a tenth. Without
// triangles one of a thousand may pass where walls meet.
TEST(Particle, NobodyLeavesAClosedRoom) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr std::uint32_t kColumns = 1000;
#else
  constexpr std::uint32_t kColumns = 20'000;
#endif
  const auto beams = spinning(50, kColumns, -89, 89, 100);
  for (std::uint32_t place = 0; place < 10; ++place) {
    const RandomBlock b = randomBlock({21, 0, 0, 0, place, 0, Purpose::Test});
    TurnedBox room;
    // Along the axes of voxels, upright, and on no axis.
    const double turn = place == 0 ? 0 : 7;
    const double tilt = place < 2 ? 0 : 7;
    room.worldFromBox = toMatrix(fromYawPitchRoll(turn * uniform(b[0]), tilt * uniform(b[1]), tilt * uniform(b[2])));
    const Scene scene = room.scene();
    const Pose pose{{}, {4 * uniform(b[3]) - 2, uniform(b[2]), uniform(b[1])}};
    for (const char* refine : {"refine: none", "refine: triangle"}) {
      const Hits hits = traced(*particle(scene, refine), shotAt(beams, pose), Channel::Range);
      const bool exact = std::string_view(refine) == "refine: triangle";
      EXPECT_LE(std::count_if(hits.range.begin(), hits.range.end(), [](float r) { return !(r < kMiss); }),
                exact ? 0 : static_cast<std::ptrdiff_t>(hits.size() / 1000))
          << refine << " " << place;
      EXPECT_TRUE(hits.unresolved.empty()) << refine << " " << place;
    }
  }
}

TEST(Particle, BoxFromOutside) {
  TurnedBox box;
  box.half = {1, 0.7, 0.5};
  box.centre = {6, 2, 0.5};
  const Scene scene = box.scene();
  const Shot shot = shotAt(spinning(128, 4096, -20, 20, 100));
  const Hits truth = traced(scene, shot);
  const Hits exact = flown(scene, shot);
  std::size_t differ = 0;
  for (std::size_t b = 0; b < truth.size(); ++b) differ += truth.hit(b) != exact.hit(b) ? 1u : 0u;
  EXPECT_LE(differ, 2u);  // at the silhouette, to rounding
  for (std::size_t b = 0; b < truth.size(); ++b) {
    if (truth.hit(b) && exact.hit(b)) {
      ASSERT_NEAR(exact.range[b], truth.range[b], 1e-4) << b;
    }
  }
  const Hits rough = flown(scene, shot, "refine: none");
  for (std::size_t b = 0; b < truth.size(); ++b) {
    EXPECT_TRUE(!truth.hit(b) || rough.hit(b)) << "a particle passed through the box: " << b;
    if (!rough.hit(b)) continue;
    const Vec3d point = shot.beams->direction[b] * double{rough.range[b]};
    EXPECT_LE(box.toWalls(point), 0.0502) << b;
    EXPECT_EQ(rough.instance[b], 1u);
  }
}

// A few things on a ground, some thin.
Scene things() {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 200, 200, 40);
  builder.place(builder.addMesh(ground), at(0, 0, -2), "ground");
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {1, 2, 3});
  const std::uint32_t boxMesh = builder.addMesh(box);
  Mesh post = meshOf(builder, "other", "dark");
  appendBox(post, 0, {}, {0.06, 0.06, 4});
  const std::uint32_t postMesh = builder.addMesh(post);
  for (std::uint32_t i = 0; i < 60; ++i) {
    const RandomBlock b = randomBlock({9, 0, 0, 0, i, 0, Purpose::Test});
    const double r = 4 + 40 * uniform(b[0]);
    const double a = 2 * kPi * uniform(b[1]);
    builder.place(i % 2 == 0 ? boxMesh : postMesh,
                  {toMatrix(fromYawPitchRoll(6 * uniform(b[2]), 0.3, 0.1)), {r * std::cos(a), r * std::sin(a), -1}},
                  "object");
  }
  return builder.finish();
}

TEST(Particle, ExhaustedBudgetIsNeitherHitNorMiss) {
  const Scene scene = groundScene(1.73);
  const Shot shot = shotAt(beamsOf(fan({0, 30, 89, 89.9}), 0, 150));
  Hits hits;
  const TraceAccount account = particle(scene, "refine: none, steps: 16")->trace(shot, Channels::all(), hits);
  ASSERT_FALSE(hits.unresolved.empty());
  EXPECT_TRUE(std::is_sorted(hits.unresolved.begin(), hits.unresolved.end()));
  for (const std::uint32_t beam : hits.unresolved) EXPECT_FALSE(hits.hit(beam));
  EXPECT_TRUE(hits.hit(0));
  ASSERT_EQ(account.warnings.size(), 1u);
  EXPECT_NE(account.warnings[0].text.find("steps"), std::string::npos);
  EXPECT_TRUE(traced(*particle(scene, "refine: none, steps: 4000"), shot).unresolved.empty());
}

TEST(Particle, NoBlindMetre) {
  for (const double depth : {0.004, 0.03, 0.2, 0.9}) {
    const Hits hits = flown(groundScene(depth), shotAt(beamsOf(fan({0, 45, 70}), 0, 10)));
    for (std::size_t b = 0; b < hits.size(); ++b) {
      EXPECT_NEAR(hits.range[b], depth / std::cos(radians(b < 40 ? 0 : b < 80 ? 45 : 70)), 1e-4) << depth;
    }
  }
}

TEST(Particle, TouchingASurfaceIsSaid) {
  const Scene scene = groundScene(0.03);
  Hits hits;
  const TraceAccount account =
      particle(scene, "refine: none")->trace(shotAt(beamsOf({{0, 0, 1}}, 0.5, 10)), Channels::all(), hits);
  EXPECT_FALSE(hits.hit(0));
  ASSERT_EQ(account.warnings.size(), 1u);
  EXPECT_NE(account.warnings[0].text.find("start within half a voxel"), std::string::npos);
}

TEST(Particle, SensorOutsideOfTheSceneAndOfItsField) {
  const Scene scene = things();
  std::vector<Vec3d> towards;
  for (int i = -20; i <= 20; ++i) towards.push_back({-1, 0.02 * i, -0.05});
  const Shot shot = shotAt(beamsOf(towards, 0, 400), {{}, {150, 0, 5}});
  const Hits truth = traced(scene, shot);
  const Hits hits = flown(scene, shot, "voxels: 128");
  EXPECT_TRUE(hits.unresolved.empty());
  for (std::size_t b = 0; b < hits.size(); ++b) {
    ASSERT_EQ(hits.hit(b), truth.hit(b)) << b;
    if (truth.hit(b)) {
      EXPECT_NEAR(hits.range[b], truth.range[b], 1e-3) << b;
    }
  }
}

TEST(Particle, ALevelTooFewIsSaid) {
  const Scene scene = groundScene(1.7);
  Hits hits;
  const TraceAccount account =
      particle(scene, "levels: 1")->trace(shotAt(beamsOf(fan({0, 89}), 0, 200)), Channels::all(), hits);
  EXPECT_TRUE(hits.hit(0));
  EXPECT_EQ(hits.unresolved.size(), 40u);
  ASSERT_EQ(account.warnings.size(), 1u);
  EXPECT_NE(account.warnings[0].text.find("levels: auto"), std::string::npos);
}

TEST(Particle, EmptySceneAndOneTriangle) {
  Scene empty;
  empty.materials.emplace_back();
  const Scene one = oneMeshScene("thing", [](Mesh& mesh) {
    mesh.positions = {{5, -1, -1}, {5, 1, -1}, {5, 0, 1}};
    mesh.triangles = {{0, 1, 2}};
    mesh.surfaceOf = {0};
  });
  const Shot shot = shotAt(beamsOf(randomDirections(500, 5), 0, 50));
  const Hits truth = traced(one, shot);
  const Hits none = flown(empty, shot);
  EXPECT_EQ(std::count_if(none.range.begin(), none.range.end(), [](float r) { return r < kMiss; }), 0);
  EXPECT_TRUE(none.unresolved.empty());
  const Hits hits = flown(one, shot);
  for (std::size_t b = 0; b < hits.size(); ++b) {
    ASSERT_EQ(hits.hit(b), truth.hit(b));
    if (truth.hit(b)) {
      EXPECT_NEAR(hits.range[b], truth.range[b], 1e-4);
    }
  }
}

TEST(Particle, VoxelsFromAMillimetreToTenMetres) {
  const Shot shot = shotAt(spinning(16, 128, -25, 5, 60));
  const Scene scene = things();
  const Hits truth = traced(scene, shot);
  for (const char* voxel : {"0.001", "0.01", "0.1", "1", "10"}) {
    const Hits hits = flown(scene, shot, std::string("voxels: 64, steps: 4000, voxel_m: ") + voxel);
    std::size_t differ = 0;
    for (std::size_t b = 0; b < hits.size(); ++b) {
      if (hits.hit(b) != truth.hit(b) || hits.instance[b] != truth.instance[b] ||
          (truth.hit(b) && std::abs(hits.range[b] - truth.range[b]) > 1e-3f)) {
        ++differ;
      }
    }
    EXPECT_LE(differ, 2u) << voxel;
    EXPECT_TRUE(hits.unresolved.empty()) << voxel;
  }
}

// Plates across the beams' way, half a metre wide at least on each side of each beam.
Scene plate(double thickness, double distance) {
  const auto fill = [&](Mesh& mesh) { appendBox(mesh, 0, {}, {thickness, 6, 6}); };
  return oneMeshScene("thing", fill, {toMatrix(fromYawPitchRoll(0.1, 0.05, 0)), {distance, 0, 0}});
}

TEST(Particle, ThinPlatesAreSeenHoweverThin) {
  std::vector<Vec3d> ahead;
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) ahead.push_back({1, 0.03 * i, 0.03 * j});
  }
  const Shot shot = shotAt(beamsOf(ahead, 0, 50));
  for (const double share : {0.01, 0.1, 0.5, 1.0, 4.0}) {
    const Scene scene = plate(share * 0.1, 5.03);
    for (const char* refine : {"none", "triangle"}) {
      const Hits hits = flown(scene, shot, std::string("refine: ") + refine);
      const auto seen = std::count_if(hits.range.begin(), hits.range.end(), [](float r) { return r < kMiss; });
      EXPECT_EQ(seen, static_cast<std::ptrdiff_t>(ahead.size())) << share << " " << refine;
    }
  }
}

// A road marking: 3 mm above the road, a thirtieth of a voxel, wherever the road lies among the voxels. Those are
// counted from the middle of the scene, which the box far below moves.
TEST(Particle, ThinLayersKeepTheirLabels) {
  const double depth = 1.7;
  for (const double shift : {0.0, 0.001, 0.02, 0.04, 0.06, 0.09, 0.1, 0.13, 0.197, 0.2}) {
    SceneBuilder builder = testBuilder();
    Mesh below = meshOf(builder, "thing");
    appendBox(below, 0, {}, {1, 1, 1});
    builder.place(builder.addMesh(below), at(0, 0, -6 - shift), "below");
    Mesh ground = meshOf(builder, "ground");
    appendPlane(ground, 0, {}, 400, 400, 8);
    builder.place(builder.addMesh(ground), at(0, 0, -depth), "ground");
    Mesh marking = meshOf(builder, "other");
    appendPlane(marking, 0, {}, 4, 4, 1);
    builder.place(builder.addMesh(marking), at(0, 0, 0.003 - depth), "marking");
    const Scene scene = builder.finish();
    const Shot shot = shotAt(beamsOf(fan({0, 10, 20, 30, 40, 44}), 0, 50));  // to 1.7 m off: the marking reaches 2
    const Shot beyond = shotAt(beamsOf(fan({60, 70}), 0, 50));
    for (const char* refine : {"refine: none", "refine: triangle"}) {
      const Hits hits = flown(scene, shot, refine);
      EXPECT_EQ(std::count(hits.semantic.begin(), hits.semantic.end(), 3), std::ptrdiff_t(hits.size()))
          << refine << " " << shift;
      const Hits road = flown(scene, beyond, refine);
      EXPECT_EQ(std::count(road.semantic.begin(), road.semantic.end(), 1), std::ptrdiff_t(road.size()))
          << refine << " " << shift;
    }
  }
}

TEST(Particle, MovingSensorsKeepEachColumnsPose) {
  const Scene scene = groundScene(1.7);
  Shot shot = shotAt(spinning(8, 64, -60, -20, 50));
  shot.worldFromSensor.clear();
  for (int step = 0; step < 16; ++step) shot.worldFromSensor.push_back({{}, {0.1 * step, 0, 0.05 * step}});
  const Hits truth = traced(scene, shot);
  const Hits hits = flown(scene, shot);
  for (std::size_t b = 0; b < hits.size(); ++b) EXPECT_NEAR(hits.range[b], truth.range[b], 1e-4) << b;
}

}  // namespace
}  // namespace scanmill
