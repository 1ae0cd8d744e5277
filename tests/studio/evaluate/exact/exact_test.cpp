#include "evaluate/exact/exact.h"

#include <thread>

#include "base/parallel.h"
#include "base/random.h"
#include "tests/core/methods/trace.h"
#include "tests/support/directions.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/same_hits.h"
#include "tests/support/street.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// Where scenes stand on maps: UTM east and north (m).
const std::vector<Vec3d> kOffsets = {{0, 0, 0}, {5e5, 5e6, 0}, {-123456.75, 4812345.5, 431.25}};

ExactHits exactly(const ExactTracer& tracer, const Shot& shot, Channels channels = Channels::all()) {
  ExactHits hits;
  tracer.trace(shot, channels, hits);
  return hits;
}

ExactHits exactly(const Scene& scene, const Shot& shot) {
  return exactly(ExactTracer(scene), shot);
}

// Spheres, boxes and capsules, turned, stretched, sheared and mirrored, some through each other.
Scene heap(std::uint32_t seed, const Vec3d& offset = {}) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {toMatrix(fromYawPitchRoll(0.2, 0.3, 0.1)), {}}, {1, 2, 3});
  Mesh sphere = meshOf(builder, "other", "dark");
  appendSphere(sphere, 0, {}, 1.0, 20);
  Mesh capsule = meshOf(builder, "ground");
  appendCapsule(capsule, 0, {}, 0.3, 2.0, 12);
  const std::uint32_t meshes[] = {builder.addMesh(box), builder.addMesh(sphere), builder.addMesh(capsule)};
  for (std::uint32_t i = 0; i < 40; ++i) {
    const RandomBlock b = randomBlock({7, seed, 0, 0, i, 0, Purpose::Test});
    const RandomBlock c = randomBlock({7, seed, 0, 0, i, 1, Purpose::Test});
    const double r = 3 + 20 * uniform(b[0]);
    const double a = 2 * kPi * uniform(b[1]);
    Mat3 linear = toMatrix(fromYawPitchRoll(6 * uniform(b[2]), 2 * uniform(c[0]), uniform(c[1]))) *
                  Mat3::scale({uniform(b[3]) < 0.3 ? -1.0 : 1.0, 0.5 + uniform(c[2]), 1 + uniform(c[3])});
    linear.x += linear.y * 0.3;
    builder.place(meshes[i % 3], {linear, offset + Vec3d{r * std::cos(a), r * std::sin(a), 8 * uniform(b[3]) - 4}},
                  "object");
  }
  return builder.finish();
}

// The nearest triangle by another formula (Moeller, Trumbore, 1997) in wider arithmetic: all of them are looked at.
struct Nearest {
  double range = INFINITY;
  std::uint32_t instance = 0;
  std::uint32_t primitive = 0;
};

Nearest bruteForce(const Scene& scene, const Vec3d& origin, const Vec3d& direction) {
  using Wide = Vec3<long double>;
  Nearest best;
  const Wide d(direction);
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto corner = [&](int k) {
        const Vec3d p = instance.worldFromMesh.linear * Vec3d(mesh.positions[mesh.triangles[t][k]]);
        return Wide(p + (instance.worldFromMesh.translation - origin));
      };
      const Wide a = corner(0);
      const Wide ab = corner(1) - a;
      const Wide ac = corner(2) - a;
      const Wide p = cross(d, ac);
      const long double determinant = dot(ab, p);
      if (determinant == 0) continue;
      const long double u = dot(-a, p) / determinant;
      const Wide q = cross(-a, ab);
      const long double v = dot(d, q) / determinant;
      const long double range = dot(ac, q) / determinant;
      if (u < 0 || v < 0 || u + v > 1 || !(range > 0) || !(static_cast<double>(range) < best.range)) continue;
      best = {static_cast<double>(range), instanceId(instance, mesh.surfaces[mesh.surfaceOf[t]]), t};
    }
  }
  return best;
}

TEST(Exact, PlaneFollowsItsClosedForm) {
  for (const Vec3d& offset : kOffsets) {
    const Scene scene = flatGround(offset - Vec3d{0, 0, 1.75}, 400, 7);
    const std::vector<double> incidences{0, 10, 45, 80, 89};
    const auto beams = beamsOf(fan(incidences));
    const ExactHits hits = exactly(scene, shotAt(beams, {{}, offset + Vec3d{0.25, -0.5, 0}}));
    for (std::size_t b = 0; b < beams->size(); ++b) {
      const double expected = 1.75 / -beams->direction[b].z;
      const double incidence = incidences[b / kFanWidth];
      EXPECT_NEAR(hits.range[b], expected, 1e-12 * expected) << incidence;
      EXPECT_EQ(hits.hits.range[b], static_cast<float>(hits.range[b]));
      EXPECT_NEAR(hits.hits.incidence[b], std::cos(radians(incidence)), 1e-7);
      EXPECT_EQ(hits.hits.normal[b], (Vec3f{0, 0, 1}));
    }
  }
}

TEST(Exact, BruteForceFindsTheSameTriangle) {
  const Vec3d sensor{0.1, 0.2, 0.3};
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    const Vec3d offset = kOffsets[seed % kOffsets.size()];
    const Scene scene = heap(seed, offset);
    const auto beams = spinning(15, 41, -18, 18);
    const ExactHits hits = exactly(scene, shotAt(beams, {{}, offset + sensor}));
    std::size_t met = 0;
    for (std::size_t b = 0; b < beams->size(); ++b) {
      const Nearest expected = bruteForce(scene, offset + sensor, beams->direction[b]);
      ASSERT_EQ(hits.hits.hit(b), expected.range < INFINITY) << b;
      if (!hits.hits.hit(b)) continue;
      ++met;
      EXPECT_EQ(hits.hits.instance[b], expected.instance) << b;
      EXPECT_EQ(hits.hits.primitive[b], expected.primitive) << b;
      EXPECT_NEAR(hits.range[b], expected.range, 1e-12 * expected.range) << b;
    }
    EXPECT_GT(met, 100u);
    EXPECT_LT(met, beams->size());
  }
}

// From inside a closed mesh, nothing gets out: neither at vertices nor anywhere along edges.
TEST(Exact, ClosedMeshesHaveNoEscapes) {
  SceneBuilder builder = testBuilder();
  Mesh mesh = meshOf(builder, "ground");
  appendSphere(mesh, 0, {toMatrix(fromYawPitchRoll(0.4, 0.3, 0.2)), {}}, 30.0, 48);
  const Affine place{toMatrix(fromYawPitchRoll(0.7, 0.4, 0.2)) * Mat3::scale({1, 0.7, -1.3}), {5e5, 5e6, 12}};
  builder.place(builder.addMesh(mesh), place, "room");
  const Scene scene = builder.finish();
  const ExactTracer tracer(scene);
  std::size_t escapes = 0;
  std::size_t rays = 0;
  for (int turn = 0; turn < 12; ++turn) {
    const Pose pose{fromYawPitchRoll(0.31 * turn, 0.17 * turn, 0.05 * turn),
                    place.translation + Vec3d{1.3 * turn, -0.7 * turn, 0.9 * turn}};
    const Mat3 sensorFromWorld = transposed(toMatrix(pose.rotation));
    std::vector<Vec3d> aims;
    const auto aim = [&](const Vec3d& p) {
      aims.push_back(sensorFromWorld * (place.linear * p + (place.translation - pose.translation)));
    };
    for (const Vec3f& p : mesh.positions) aim(Vec3d(p));
    for (const Triangle& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        const Vec3d a(mesh.positions[t[k]]);
        const Vec3d b(mesh.positions[t[(k + 1) % 3]]);
        for (const double s : {0.5, 0.25, 1e-3, 1e-9, 1e-15}) aim(a + (b - a) * s);
      }
    }
    const ExactHits hits = exactly(tracer, shotAt(beamsOf(aims), pose), Channel::Range);
    for (std::size_t b = 0; b < aims.size(); ++b) {
      if (!hits.hits.hit(b)) {
        ++escapes;
      } else {
        EXPECT_NEAR(hits.range[b], length(aims[b]), 1e-11);
      }
    }
    rays += aims.size();
  }
  EXPECT_EQ(escapes, 0u) << "of " << rays;
}

// Along axes, and an ulp off them.
TEST(Exact, ComponentsThatAreNearlyZeroLoseNothing) {
  const Scene scene = oneMeshScene("thing", [](Mesh& box) { appendBox(box, 0, {}, {2, 2, 2}); });
  const ExactTracer tracer(scene);
  std::vector<Vec3d> directions;
  for (const double tiny : {0.0, -0.0, 4e-19, -4e-19, -1e-17, 1e-13, -1e-300}) {
    for (const double side : {-1.0, 1.0}) {
      directions.insert(directions.end(), {{side, tiny, tiny}, {tiny, side, tiny}, {tiny, tiny, side}});
    }
  }
  for (const Vec3d& sensor : {Vec3d{}, Vec3d{0.5, 0, 0}, Vec3d{0, -0.25, 0.125}}) {
    const ExactHits hits = exactly(tracer, shotAt(beamsOf(directions), {{}, sensor}));
    for (std::size_t b = 0; b < directions.size(); ++b) {
      const Vec3d& d = directions[b];
      const double expected = 1 - dot(d, sensor);
      EXPECT_NEAR(hits.range[b], expected, 1e-12) << d.x << " " << d.y << " " << d.z;
    }
  }
}

TEST(Exact, RangeLimits) {
  const Scene scene = wallAhead();
  const ExactTracer tracer(scene);
  const auto range = [&](double minimum, double maximum, double x = 0) {
    return exactly(tracer, shotAt(beamsOf({{1, 0, 0}}, minimum, maximum), {{}, {x, 0, 0}})).range[0];
  };
  EXPECT_EQ(range(0, 10), 10.0) << "exactly the maximum counts";
  EXPECT_EQ(range(10, 20), 10.0) << "exactly the minimum counts";
  EXPECT_EQ(range(0, 10 - 1e-9), INFINITY) << "beyond";
  EXPECT_EQ(range(10 + 1e-9, 20), INFINITY) << "nearer than the minimum";
  EXPECT_EQ(range(0, 20, 10), INFINITY) << "a sensor on the surface sees nothing of it";
  EXPECT_EQ(range(0, 20, 9.999), 10 - 9.999);
  EXPECT_EQ(range(0, 20, 10.5), INFINITY) << "behind";
}

TEST(Exact, NearSurfaceBlocksWhatLiesBehind) {
  const ExactHits hits = exactly(wallsAhead({1, 10}), shotAt(beamsOf({{1, 0, 0}}, 2, 100)));
  EXPECT_EQ(hits.range[0], INFINITY);
  EXPECT_EQ(hits.hits.range[0], kMiss);
}

TEST(Exact, MissesAreZeroed) {
  for (const Scene& scene : {heap(1), Scene()}) {
    const ExactHits hits = exactly(scene, shotAt(beamsOf({{0, 0, 1}})));
    ASSERT_EQ(hits.range.size(), 1u);
    EXPECT_EQ(hits.range[0], INFINITY);
    expectZeroedMiss(hits.hits);
  }
}

TEST(Exact, OnlyAskedChannelsAreFilled) {
  const Scene scene = heap(2);
  const ExactTracer tracer(scene);
  const Shot shot = shotAt(spinning(4, 61, -20, 10));
  const ExactHits all = exactly(tracer, shot);
  const ExactHits some = exactly(tracer, shot, Channel::Semantic);
  EXPECT_EQ(some.range, all.range);
  EXPECT_EQ(some.hits.semantic, all.hits.semantic);
  EXPECT_TRUE(some.hits.instance.empty() && some.hits.normal.empty() && some.hits.reflectance.empty() &&
              some.hits.incidence.empty() && some.hits.material.empty() && some.hits.primitive.empty());
}

TEST(Exact, CoplanarSurfacesGiveTheLowestInstance) {
  const auto beams = spinning(64, 512, -40, 40);
  for (const bool coarseFirst : {true, false}) {
    const CoplanarWalls walls(coarseFirst);
    const ExactHits hits = exactly(walls.scene, shotAt(beams));
    walls.expectTheFirst(*beams, hits.hits, hits.range, 1e-11);
  }
}

// Whether surfaces are coplanar is asked of the nearest alone, so the order of things does not show: of three walls 12
// micrometres apart, the last is too far from the first.
TEST(Exact, TiesAreAskedOfTheNearest) {
  const double step = 12e-6;
  for (const auto& order :
       std::vector<std::vector<int>>{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
    std::vector<double> distances;
    for (const int place : order) distances.push_back(1 + step * place);
    const ExactHits hits = exactly(wallsAhead(distances), shotAt(beamsOf({{1, 0.01, 0.02}})));
    // Ids count from 1 in the order of placement: the winner is the earlier of walls 0 and 1.
    const auto first = std::ranges::find_if(order, [](int place) { return place < 2; });
    EXPECT_EQ(hits.hits.instance[0], static_cast<std::uint32_t>(first - order.begin()) + 1);
    EXPECT_NEAR(hits.range[0], (1 + step * *first) * std::sqrt(1 + 1e-4 + 4e-4), 1e-12);
  }
}

TEST(Exact, LayersThatLieApartKeepTheirOwnLabels) {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 200, 200, 10);
  builder.place(builder.addMesh(ground), at(0, 0, -1.8), "ground");
  Mesh paint = meshOf(builder, "thing");
  appendPlane(paint, 0, {}, 100, 100, 1);
  builder.place(builder.addMesh(paint), at(0, 0, -1.7999), "paint");
  const ExactHits hits = exactly(builder.finish(), shotAt(spinning(32, 256, -60, -4)));
  for (std::size_t b = 0; b < hits.range.size(); ++b) EXPECT_EQ(hits.hits.instance[b], 1u) << hits.range[b];
}

TEST(Exact, AlphaLetsBeamsThrough) {
  std::vector<Vec3d> directions = towardsTheCurtain();
  directions.push_back({1, 0.1, 1.1});
  const ExactHits hits = exactly(curtain(), shotAt(beamsOf(directions)));
  for (std::size_t b = 0; b + 1 < directions.size(); ++b) {
    const bool there = directions[b].y > 0;
    EXPECT_EQ(hits.hits.semantic[b], there ? 2 : 1) << "y " << directions[b].y;
    EXPECT_NEAR(hits.range[b], (there ? 5 : 10) * length(directions[b]), 1e-12);
  }
  EXPECT_EQ(hits.hits.semantic.back(), 3);
  EXPECT_EQ(hits.hits.primitive.back() / 2, 1u) << "the index in the mesh";
}

TEST(Exact, TextureScalesReflectance) {
  const ExactHits hits = exactly(paintedWall(), shotAt(beamsOf({{1, 0.3, 0.1}, {1, -0.3, 0.1}})));
  EXPECT_FLOAT_EQ(hits.hits.reflectance[0], 0.8f);
  EXPECT_FLOAT_EQ(hits.hits.reflectance[1], 0.0f);
}

TEST(Exact, BeamOriginsAndPosesMove) {
  const ExactHits hits = exactly(wallAhead(), steppingAhead());
  for (std::uint32_t c = 0; c < 40; ++c) {
    EXPECT_EQ(hits.range[c], 9.75 - 0.5 * static_cast<double>(c * 7 / 40)) << c;
  }
}

// A beam far from the revolution's first pose is rounded more, and has more slack.
TEST(Exact, TurnsOfKilometresToo) {
  SceneBuilder builder = testBuilder();
  Mesh speck = meshOf(builder, "thing");
  appendBox(speck, 0, {}, {0.001, 0.001, 0.001});
  const std::uint32_t mesh = builder.addMesh(speck);
  Shot shot = shotAt(beamsOf(std::vector<Vec3d>(64, {1, 0, 0}), 0, 1e6));
  shot.worldFromSensor.clear();
  for (int step = 0; step < 64; ++step) {
    const Vec3d place{1 + 0.1 * step, 1234.567 * step, 77.7 * step};
    builder.place(mesh, at(place.x + 10, place.y + 0.0004, place.z), "speck");
    shot.worldFromSensor.push_back({{}, place});
  }
  const ExactHits hits = exactly(builder.finish(), shot);
  for (std::uint32_t c = 0; c < 64; ++c) {
    EXPECT_NEAR(hits.range[c], 9.9995, 1e-8) << c;
    EXPECT_EQ(hits.hits.instance[c], c + 1);
  }
}

// Back to a millimetre that was near at first.
TEST(Exact, SpecksAreFoundFromAfar) {
  SceneBuilder builder = testBuilder();
  Mesh speck = meshOf(builder, "thing");
  appendBox(speck, 0, {}, {0.001, 0.001, 0.001});
  builder.place(builder.addMesh(speck), at(0.3, 0.2, 0.1), "speck");
  std::vector<Vec3d> directions = randomDirections(64, 9);
  Shot shot = shotAt(beamsOf(directions, 0, 1e6));
  shot.worldFromSensor = {{{}, Vec3d{0.3, 0.2, 0.1} + shot.beams->direction[0] * -2.0}};
  for (std::size_t c = 1; c < directions.size(); ++c) {
    shot.worldFromSensor.push_back({{}, Vec3d{0.3, 0.2, 0.1} + shot.beams->direction[c] * -123456.7});
  }
  const ExactHits hits = exactly(builder.finish(), shot);
  for (std::size_t c = 0; c < directions.size(); ++c) EXPECT_NEAR(hits.range[c], c == 0 ? 2 : 123456.7, 0.001) << c;
}

TEST(Exact, MirroredInstancesKeepTheirNormalsTowardsTheSensor) {
  const ExactHits hits = exactly(mirroredBox(), shotAt(beamsOf({{1, 0.01, 0.02}})));
  EXPECT_NEAR(hits.hits.normal[0].x, -1, 1e-7);
  EXPECT_NEAR(hits.range[0], 4 / normalized(Vec3d{1, 0.01, 0.02}).x, 1e-12);
}

TEST(Exact, ThreadsDoNotMatter) {
  const Scene scene = heap(3);
  const Shot shot = shotAt(spinning(64, 1000, -25, 25));
  std::vector<ExactHits> results;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    results.push_back(exactly(scene, shot));
  }
  for (const ExactHits& other : results) {
    EXPECT_EQ(other.range, results[0].range);
    expectSameHits(other.hits, results[0].hits);
  }
}

TEST(Exact, SeveralThreadsMayTraceAtOnce) {
  const Scene scene = heap(4);
  const ExactTracer tracer(scene);
  std::vector<Shot> shots;
  for (int i = 0; i < 4; ++i) shots.push_back(shotAt(spinning(16, 200, -25, 25), {{}, {1500.0 * i, 0, 0}}));
  std::vector<ExactHits> together(shots.size());
  onThreads(shots.size(), [&](std::size_t i) { tracer.trace(shots[i], Channels::all(), together[i]); });
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const ExactHits alone = exactly(scene, shots[i]);
    EXPECT_EQ(together[i].range, alone.range);
    expectSameHits(together[i].hits, alone.hits);
  }
}

// Float32 decides otherwise only where a beam passes within its rounding of an edge.
TEST(Exact, RayTracingAgreesOnTheStreet) {
  const Scene scene = proceduralStreet();
  const ExactTracer tracer(scene);
  const auto method = rayTracing(scene);
  const auto beams = presetBeams("paper_64");
  double otherHits = 0;
  double otherLabels = 0;
  double otherTriangles = 0;
  double total = 0;
  double worst = 0;  // of the range, relative, where both meet the same triangle
  double steepest = 0;
  for (const double x : {-60.0, 5.0, 110.0}) {
    const Shot shot = streetShot(beams, x);
    const ExactHits exact = exactly(tracer, shot);
    const Hits& truth = exact.hits;
    const Hits hits = traced(*method, shot);
    for (std::size_t b = 0; b < hits.size(); ++b) {
      ++total;
      if (hits.hit(b) != truth.hit(b)) ++otherHits;
      if (!hits.hit(b) || !truth.hit(b)) continue;
      if (hits.instance[b] != truth.instance[b] || hits.semantic[b] != truth.semantic[b]) {
        ++otherLabels;
      } else if (hits.primitive[b] != truth.primitive[b]) {
        ++otherTriangles;
      } else {
        worst = std::max(worst, std::abs(double{hits.range[b]} - exact.range[b]) / exact.range[b]);
        steepest = std::max(steepest, std::abs(double{hits.incidence[b]} - double{truth.incidence[b]}));
        EXPECT_EQ(hits.material[b], truth.material[b]);
        EXPECT_EQ(hits.reflectance[b], truth.reflectance[b]);
      }
    }
  }
  const double perMillion = 1e6 / total;
  RecordProperty("hit_or_miss_differs_per_million", std::to_string(otherHits * perMillion));
  RecordProperty("label_differs_per_million", std::to_string(otherLabels * perMillion));
  RecordProperty("largest_relative_difference", std::to_string(worst));
  EXPECT_LE(otherHits * perMillion, 20);
  EXPECT_LE(otherLabels * perMillion, 60);
  EXPECT_LE(otherTriangles * perMillion, 200);
  EXPECT_LE(worst, 1e-7) << "the range is rounded to float32";
  EXPECT_LE(steepest, 1e-6);
}

}  // namespace
}  // namespace scanmill
