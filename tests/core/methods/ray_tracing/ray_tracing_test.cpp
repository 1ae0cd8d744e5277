#include <fmt/format.h>

#include <vector>

#include "base/error.h"
#include "base/random.h"
#include "tests/core/methods/trace.h"
#include "tests/support/directions.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/same_hits.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

TEST(RayTracing, PlaneFollowsItsClosedFormToGrazingIncidence) {
  const Scene scene = flatGround({0, 0, -1.7}, 1e5, 7);
  const std::vector<double> incidences{0, 10, 45, 80, 89, 89.9, 89.95, 89.99};
  const std::vector<Vec3d> directions = fan(incidences);
  const Hits hits = traced(scene, shotAt(beamsOf(directions, 0, 1e5)));
  for (std::size_t b = 0; b < directions.size(); ++b) {
    const double incidence = incidences[b / kFanWidth];
    const double cosine = std::cos(radians(incidence));
    EXPECT_NEAR(hits.range[b], 1.7 / -normalized(directions[b]).z, 1e-5 / cosine) << incidence;
    EXPECT_NEAR(hits.incidence[b], cosine, 1e-6);
    EXPECT_EQ(hits.normal[b], (Vec3f{0, 0, 1}));
  }
}

// Rays that end where the ego vehicle blocks them have all hits before that, and none far behind it.
TEST(RayTracing, BlockedRaysKeepWhatIsBeforeTheVehicle) {
  const Scene scene = yard();
  const auto method = rayTracing(scene);
  Shot shot = shotAt(spinning(32, 500, -25, 5, 60));
  const Hits open = traced(*method, shot);
  std::vector<float> blocked(open.size(), kMiss);
  for (std::size_t i = 0; i < blocked.size(); ++i) {
    const RandomBlock b = randomBlock({8, 0, 0, 0, static_cast<std::uint32_t>(i), 0, Purpose::Test});
    if (i % 3 == 0) blocked[i] = static_cast<float>(30 * uniform(b[0]));
    if (i % 9 == 0) blocked[i] = open.range[i];
  }
  shot.blockedBeyond = blocked;
  const Hits ended = traced(*method, shot);
  std::size_t before = 0;
  for (std::size_t i = 0; i < blocked.size(); ++i) {
    if (open.range[i] <= blocked[i]) {
      ASSERT_EQ(ended.range[i], open.range[i]) << i;
      ASSERT_EQ(ended.instance[i], open.instance[i]);
      ASSERT_EQ(ended.normal[i], open.normal[i]);
      before += i % 3 == 0 && open.hit(i) ? 1 : 0;
    } else if (open.range[i] > 1.1f * blocked[i] + 0.1f) {
      ASSERT_EQ(ended.range[i], kMiss) << i;
    }
  }
  EXPECT_GT(before, 500u);
}

// A turned sensor's axes are often an ulp off the world's.
TEST(RayTracing, ComponentsThatAreNearlyZeroLoseNothing) {
  const Scene scene = yard();
  for (const double tiny : {-4e-19, -1e-17, -1e-30, 4e-19, -0.0}) {
    for (const Vec3d& forward :
         {Vec3d{0.969, tiny, -0.2463}, Vec3d{tiny, -0.969, -0.2463}, Vec3d{-0.969, tiny, -0.2463}}) {
      std::vector<Vec3d> directions;
      const Vec3d aside = std::abs(forward.x) > 0.5 ? Vec3d{0, -0.0034, 0} : Vec3d{-0.0034, 0, 0};
      for (int i = 0; i < 64; ++i) directions.push_back(forward + aside * double(i));
      for (const double height : {0.0, 0.4, 3.0}) {
        const Shot shot = shotAt(beamsOf(directions), {{}, {0.3, -0.2, height}});
        const Hits hits = traced(scene, shot);
        EXPECT_EQ(std::count(hits.range.begin(), hits.range.end(), kMiss), 0) << tiny;
      }
    }
  }
}

TEST(RayTracing, FarFromTheScenesCentreToo) {
  // 5 km from the anchor: another origin on the grid, the same ranges.
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {2, 2, 2});
  const std::uint32_t mesh = builder.addMesh(box);
  builder.place(mesh, at(-5000.25, 0, 0), "west");
  builder.place(mesh, at(5000.25, 0, 0), "east");
  const Scene scene = builder.finish();
  const auto method = rayTracing(scene);
  for (const double side : {-1.0, 1.0}) {
    const Hits hits = traced(*method, shotAt(beamsOf({{side, 0, 0}}, 0, 100), {{}, {side * 4990.0, 0.1, 0.2}}));
    EXPECT_NEAR(hits.range[0], 9.25, 1e-6);
  }
}

TEST(RayTracing, RangeLimits) {
  const Scene scene = wallAhead();
  const auto method = rayTracing(scene);
  const auto range = [&](double minimum, double maximum, double x = 0) {
    return traced(*method, shotAt(beamsOf({{1, 0, 0}}, minimum, maximum), {{}, {x, 0, 0}})).range[0];
  };
  EXPECT_EQ(range(0, 10), 10.0f) << "exactly the maximum counts";
  EXPECT_EQ(range(10, 20), 10.0f) << "exactly the minimum counts";
  EXPECT_EQ(range(0, 9.999999), kMiss) << "beyond";
  EXPECT_EQ(range(10.000001, 20), kMiss) << "nearer than the minimum";
  EXPECT_EQ(range(0, 20, 10), kMiss) << "a sensor on the surface sees nothing of it";
  EXPECT_EQ(range(0, 20, 9.999), static_cast<float>(10 - 9.999));
  EXPECT_EQ(range(0, 20, 10.5), kMiss) << "behind";
}

TEST(RayTracing, ClosedRoomHasNoEscapes) {
  const Scene scene = ballRoom([](Mesh& room) {
    appendBox(room, 0, {toMatrix(fromYawPitchRoll(0.3, 0.2, 0.1)), {}}, {120, 120, 120});
  });
  const auto method = rayTracing(scene);
  Hits hits;
  std::size_t misses = 0;
  std::size_t rays = 0;
  for (std::uint32_t shot = 0; rays < 10'000'000; ++shot) {
    const auto beams = beamsOf(randomDirections(50'000, shot));
    for (int turn = 0; turn < 20; ++turn) {  // the same directions, turned and moved
      const Pose pose{fromYawPitchRoll(0.31 * turn, 0.17 * turn, 0.05 * turn), {0.5 * turn, -0.3 * turn, 0.2 * turn}};
      method->trace(shotAt(beams, pose), Channel::Range, hits);
      for (const float range : hits.range) misses += range < kMiss ? 0 : 1;
      rays += hits.size();
    }
  }
  EXPECT_EQ(misses, 0u) << "of " << rays;
}

// Tables of few and of many rings are traced in tiles of all shapes, from one column to sixteen.
TEST(RayTracing, AnyTileGivesTheSame) {
  const Scene scene = yard();
  for (const auto& [rings, columns] :
       {std::pair(257u, 67u), {129u, 133u}, {65u, 261u}, {33u, 517u}, {9u, 2051u}, {1u, 17u}, {17u, 1u}}) {
    SCOPED_TRACE(rings);
    const auto beams = spinning(rings, columns, -25, 5);
    Hits inOneRing = traced(scene, shotAt(beamsOf(beams->direction, beams->minRange, beams->maxRange)));
    inOneRing.rings = rings;
    inOneRing.columns = columns;
    expectSameHits(traced(scene, shotAt(beams)), inOneRing);
  }
}

TEST(RayTracing, InstancedOrFlattenedGivesTheSame) {
  const Scene scene = yard();
  const Shot shot = shotAt(spinning(64, 1024, -25, 5));
  const Hits flat = traced(scene, shot, "{instancing: never}");
  const Hits instanced = traced(scene, shot, "{instancing: always}");
  std::size_t different = 0;  // silhouettes: float32 rounding differs between the two frames
  for (std::size_t b = 0; b < flat.size(); ++b) {
    if (flat.instance[b] != instanced.instance[b]) {
      ++different;
    } else if (flat.hit(b) && flat.primitive[b] != instanced.primitive[b]) {  // a shared edge
      EXPECT_NEAR(instanced.range[b], flat.range[b], 1e-4 * flat.range[b]);
    } else if (flat.hit(b)) {
      EXPECT_NEAR(instanced.range[b], flat.range[b], 1e-6 * flat.range[b]);
      EXPECT_NEAR(instanced.incidence[b], flat.incidence[b], 1e-6);
    }
  }
  EXPECT_LE(different, flat.size() / 10000);
}

TEST(RayTracing, TinyAndHugeTrianglesInOneScene) {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendQuad(ground, 0, {-1e5, -1e5, -1}, {1e5, -1e5, -1}, {1e5, 1e5, -1}, {-1e5, 1e5, -1});
  builder.place(builder.addMesh(ground), {}, "ground");
  Mesh speck = meshOf(builder, "thing");
  // A triangle of a micrometre, 1 cm before the sensor, around the x axis.
  speck.positions = {{0.01f, -5e-7f, -5e-7f}, {0.01f, 5e-7f, -5e-7f}, {0.01f, 0, 5e-7f}};
  speck.triangles = {{0, 1, 2}};
  speck.surfaceOf = {0};
  builder.place(builder.addMesh(speck), {}, "speck");
  const Scene scene = builder.finish();
  EXPECT_EQ(scene.dropped.total(), 0u);
  const Hits hits = traced(scene, shotAt(beamsOf({{1, 0, 0}, {1, 1e-3, 0}, {1, 0, -1e-5}, {0, 0, -1}}, 0, 2e5)));
  EXPECT_EQ(hits.instance[0], 1u);
  EXPECT_NEAR(hits.range[0], 0.01, 1e-8);
  EXPECT_EQ(hits.range[1], kMiss);
  EXPECT_EQ(hits.semantic[3], 1u);
  EXPECT_NEAR(hits.range[3], 1.0, 1e-7);
}

// The later wall is placed first or second, baked or instanced.
TEST(RayTracing, CoplanarSurfacesGiveTheLowestInstance) {
  const auto beams = spinning(64, 512, -40, 40);
  for (const bool coarseFirst : {true, false}) {
    const CoplanarWalls walls(coarseFirst);
    for (const char* options : {"{instancing: never}", "{instancing: always}"}) {
      SCOPED_TRACE(options);
      const Hits hits = traced(walls.scene, shotAt(beams), options);
      walls.expectTheFirst(*beams, hits, hits.range, 1e-5);
    }
  }
}

TEST(RayTracing, ExactDuplicatesHaveTheSameRange) {
  const auto boxes = [](int count) {
    SceneBuilder builder = testBuilder();
    Mesh box = meshOf(builder, "thing");
    appendBox(box, 0, {}, {4, 4, 4});
    const std::uint32_t mesh = builder.addMesh(box);
    const Affine place{toMatrix(fromYawPitchRoll(1, 0.5, 0.25)), {12, 3, 0}};
    for (int i = 0; i < count; ++i) builder.place(mesh, place, "box");
    return builder.finish();
  };
  const Scene once = boxes(1);
  const Scene many = boxes(6);
  const Shot shot = shotAt(spinning(32, 2048, -30, 30));
  for (const char* options : {"{instancing: never}", "{instancing: always}"}) {
    expectSameHits(traced(many, shot, options), traced(once, shot, options));
  }
}

TEST(RayTracing, AlphaLetsBeamsThrough) {
  const Scene scene = curtain();
  const std::vector<Vec3d> directions = towardsTheCurtain();
  for (const char* options : {"{instancing: never}", "{instancing: always}"}) {
    const Hits hits = traced(scene, shotAt(beamsOf(directions)), options);
    for (std::size_t b = 0; b < directions.size(); ++b) {
      EXPECT_EQ(hits.semantic[b], directions[b].y > 0 ? 2 : 1) << options << " y " << directions[b].y;
    }
  }
}

TEST(RayTracing, TextureScalesReflectance) {
  const Hits hits = traced(paintedWall(), shotAt(beamsOf({{1, 0.3, 0.1}, {1, -0.3, 0.1}})));
  EXPECT_FLOAT_EQ(hits.reflectance[0], 0.8f);
  EXPECT_FLOAT_EQ(hits.reflectance[1], 0.0f);
}

TEST(RayTracing, BeamOriginsAndPosesMove) {
  const Hits hits = traced(wallAhead(), steppingAhead());
  for (std::uint32_t c = 0; c < 40; ++c) {
    EXPECT_EQ(hits.range[c], static_cast<float>(9.75 - 0.5 * static_cast<double>(c * 7 / 40))) << c;
  }
}

TEST(RayTracing, MirroredInstancesKeepTheirNormalsTowardsTheSensor) {
  const Scene scene = mirroredBox();
  for (const char* options : {"{instancing: never}", "{instancing: always}"}) {
    const Hits hits = traced(scene, shotAt(beamsOf({{1, 0.01, 0.02}})), options);
    EXPECT_NEAR(hits.normal[0].x, -1, 1e-6);
    EXPECT_NEAR(hits.range[0], 4 / normalized(Vec3d{1, 0.01, 0.02}).x, 1e-6);
  }
}

std::string geometryOf(const Method& method) {
  return lineOf(method.modelled().front());
}

TEST(RayTracing, SimplifiedMeshesAreTraced) {
  SceneBuilder builder = testBuilder();
  Mesh sphere = meshOf(builder, "thing");
  appendSphere(sphere, 0, {}, 2.0, 128);
  const std::uint32_t mesh = builder.addMesh(sphere);
  builder.place(mesh, at(0, 0, 0), "first");
  builder.place(mesh, at(0, 0, 0), "second");
  const Scene scene = builder.finish();
  const Shot shot = shotAt(beamsOf(randomDirections(20000)));
  for (const char* instancing : {"never", "always"}) {
    double last = 1e-6;
    for (const double keep : {1.0, 0.3, 0.05}) {
      const auto method = rayTracing(scene, fmt::format("{{simplify: {}, instancing: {}}}", keep, instancing));
      const Hits hits = traced(*method, shot);
      double worst = 0;
      for (std::size_t b = 0; b < hits.size(); ++b) {
        ASSERT_TRUE(hits.hit(b)) << "a closed mesh stays closed";
        worst = std::max(worst, std::abs(2.0 - double{hits.range[b]}));
        EXPECT_EQ(hits.instance[b], 1u);
        EXPECT_EQ(hits.semantic[b], 2u);
        EXPECT_LE(hits.primitive[b], keep * static_cast<double>(sphere.triangles.size()) + 4);
      }
      EXPECT_GT(worst, last) << keep;
      EXPECT_LT(worst, 0.1);
      last = worst;
    }
  }
}

TEST(RayTracing, ModelledTellsOfSimplifiedMeshes) {
  const Scene scene = yard();
  EXPECT_EQ(geometryOf(*rayTracing(scene)), "geometry: exact triangles, one hit per ray, watertight");
  const auto method = rayTracing(scene, "{simplify: 0.5}");
  EXPECT_THAT(geometryOf(*method), testing::StartsWith("geometry: simplified meshes, "));
  EXPECT_THAT(geometryOf(*method), testing::HasSubstr(fmt::format("of {} placed", scene.placedTriangles())));
  expectSameHits(traced(*rayTracing(scene, "{simplify: 1}"), shotAt(spinning(16, 512, -25, 5))),
                 traced(*rayTracing(scene), shotAt(spinning(16, 512, -25, 5))));
}

TEST(RayTracing, UnknownOptionsAreRefused) {
  const Scene scene = yard();
  EXPECT_THROW(rayTracing(scene, "{packet: 16}"), InputError);
  EXPECT_THROW(rayTracing(scene, "{instancing: some}"), InputError);
  for (const char* share : {"0", "0.009", "1.01", "-1", "half"}) {
    EXPECT_THROW(rayTracing(scene, fmt::format("{{simplify: {}}}", share)), InputError) << share;
  }
  EXPECT_THROW(requireMethod("ray_tracin", {"x.yaml", 3, 1}), InputError);
}

}  // namespace
}  // namespace scanmill
