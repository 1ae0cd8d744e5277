#include "evaluate/measure.h"

#include <chrono>
#include <numeric>
#include <thread>

#include "base/error.h"
#include "base/parallel.h"
#include "tests/core/methods/trace.h"
#include "tests/support/message_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// Ground 2 m below the sensor, with a box, a pole and a ball before it.
Scene courtyard() {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 60, 60);
  builder.place(builder.addMesh(ground), at(0, 0, -2), "ground");
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, {}, {1, 2, 3});
  builder.place(builder.addMesh(box), {toMatrix(fromYawPitchRoll(0.4, 0, 0)), {6, 0, -0.5}}, "box");
  Mesh pole = meshOf(builder, "other", "dark");
  appendCylinder(pole, 0, {}, 0.02, 0.02, 3);
  builder.place(builder.addMesh(pole), at(0, 5, -0.5), "pole");
  Mesh ball = meshOf(builder, "thing");
  appendSphere(ball, 0, {}, 1);
  builder.place(builder.addMesh(ball), at(-5, -2, -1), "ball");
  return builder.finish();
}

std::vector<Shot> twoShots() {
  const auto beams = spinning(24, 256, -25, 5, 15);
  return {shotAt(beams), shotAt(beams, {fromYawPitchRoll(1, 0, 0), {0.3, -0.2, 0.1}})};
}

// Notes its scans and holds so many bytes.
class Counting : public Method {
 public:
  Counting(const Scene& scene, std::size_t bytes, std::vector<Channels>& scans)
      : rays_(rayTracing(scene)), bytes_(bytes), scans_(scans) {}

  TraceAccount prepare(const Shot&) const override {
    held_.assign(bytes_, 'x');
    return {{{"build", 7}}, {}};
  }
  // Whatever is compared takes ten times as long.
  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    scans_.push_back(channels);
    rays_->trace(shot, channels, hits);
    return {{{"fly", channels.has(Channel::Incidence) ? 5 : 0.5}}, {{shot.sensorName, 0, 1, "slow"}}};
  }
  std::vector<ModelledItem> modelled() const override { return {}; }
  std::uint64_t memoryBytes() const override { return bytes_; }

 private:
  std::unique_ptr<Method> rays_;
  std::size_t bytes_;
  std::vector<Channels>& scans_;
  mutable std::vector<char> held_;
};

// What ray tracing sees, as truth.
std::vector<TrueShot> seenByRays(const Scene& scene) {
  std::vector<TrueShot> shots;
  for (const Shot& shot : twoShots()) {
    TrueShot truth;
    truth.shot = shot;
    truth.truth.hits = traced(scene, shot);
    truth.truth.range.assign(truth.truth.hits.range.begin(), truth.truth.hits.range.end());
    shots.push_back(truth);
  }
  return shots;
}

TEST(Measure, TimesOnlyTheScansAndChannelsThatAreAskedFor) {
  const Scene scene = courtyard();
  const std::vector<TrueShot> shots = seenByRays(scene);
  std::vector<Channels> scans;
  MeasureOptions options{.repeats = 4, .channels = Channel::Instance};
  const auto make = [&] { return std::make_unique<Counting>(scene, std::size_t{32} << 20, scans); };
  const Measurement m = measure(make, scene, shots, options);
  EXPECT_EQ(m.cost.stages, (std::map<std::string, double>{{"build", 0}, {"fly", 0.5}}));
  EXPECT_EQ(m.cost.memoryBytes, 32u << 20);
  EXPECT_GE(m.cost.residentBytes, 31u << 20);
  EXPECT_GT(m.cost.setupSeconds, 0);
  EXPECT_GT(m.cost.fastest, 0);
  EXPECT_LE(m.cost.fastest, m.cost.scanSeconds);
  EXPECT_LE(m.cost.scanSeconds, m.cost.slowest);
  EXPECT_EQ(m.warnings, std::vector<std::string>{"slow"});
  const Channels timed = Channel::Instance | Channel::Range;
  EXPECT_EQ(std::ranges::count(scans, timed), 10);
  EXPECT_EQ(std::ranges::count(scans, timed | kErrorChannels), 2);
  EXPECT_EQ(scans.size(), 12u);

  // No scan but the timed ones where these say all.
  scans.clear();
  options.channels = kErrorChannels;
  measure(make, scene, shots, options);
  EXPECT_EQ(scans, std::vector<Channels>(10, kErrorChannels));
}

TEST(Measure, FastScansAreRepeatedFurther) {
  const Scene scene = courtyard();
  MeasureOptions options{.repeats = 2, .channels = kErrorChannels};
  const std::vector<TrueShot> truth = trueShots(scene, {twoShots().front()}, options);
  const auto scansWith = [&](double leastSeconds) {
    options.leastSeconds = leastSeconds;
    std::vector<Channels> scans;
    measure([&] { return std::make_unique<Counting>(scene, 1, scans); }, scene, truth, options);
    return scans.size();
  };
  EXPECT_EQ(scansWith(0), 3u);
  EXPECT_EQ(scansWith(1e9), 31u);
}

// Sleeps longer for larger scans.
class Slow : public Counting {
 public:
  using Counting::Counting;
  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    std::this_thread::sleep_for(std::chrono::milliseconds(shot.sensor == 0 ? 2 : 20));
    return Counting::trace(shot, channels, hits);
  }
};

// Of two sensors with scans of two sizes neither one's time stands for both; sleeping never ends early.
TEST(Measure, SensorsCountByTheirNumberOfScans) {
  const Scene scene = courtyard();
  std::vector<Shot> shots = twoShots();
  shots.push_back(shots.front());
  shots.push_back(shots.front());
  shots[3].sensor = 1;
  const MeasureOptions options{.repeats = 1};
  const std::vector<TrueShot> truth = trueShots(scene, shots, options);
  std::vector<Channels> scans;
  const Cost cost = measure([&] { return std::make_unique<Slow>(scene, 1, scans); }, scene, truth, options).cost;
  EXPECT_GE(cost.fastest, (3 * 2e-3 + 20e-3) / 4);
  EXPECT_GE(cost.scanSeconds, cost.fastest);
  EXPECT_GE(cost.slowest, cost.scanSeconds);
}

TEST(Measure, AnyHitTellsABlindSensor) {
  EXPECT_TRUE(anyHit(trueShots(courtyard(), twoShots(), {})));
  std::vector<Shot> blind = twoShots();
  for (Shot& shot : blind) shot.worldFromSensor.front().translation.z = 5000;
  EXPECT_FALSE(anyHit(trueShots(courtyard(), blind, {})));
  EXPECT_FALSE(anyHit({}));
}

TEST(Measure, StopsBetweenScans) {
  const Scene scene = courtyard();
  const std::vector<TrueShot> shots = seenByRays(scene);
  MeasureOptions options;
  int scans = 0;
  options.stop = [&] { return ++scans > 3; };
  EXPECT_THROW(measure([&] { return rayTracing(scene); }, scene, shots, options), Error);
  options.stop = [] { return true; };
  EXPECT_THROW(trueShots(scene, twoShots(), options), Error);
  EXPECT_THROW(measure([&] { return rayTracing(scene); }, scene, {}, {}), Error);
}

TEST(Measure, WithoutRepeatsOnlyErrorsAreMeasured) {
  const Scene scene = courtyard();
  const std::vector<TrueShot> shots = seenByRays(scene);
  const MeasureOptions options{.repeats = 0};
  std::vector<Channels> scans;
  const Measurement m = measure([&] { return std::make_unique<Counting>(scene, 0, scans); }, scene, shots, options);
  EXPECT_EQ(m.cost.scanSeconds, 0);
  EXPECT_TRUE(m.cost.stages.empty());
  EXPECT_EQ(m.errors.all.beams, 2u * 24 * 256);
}

TEST(Measure, RaysAreTrueAndCoarseParticlesAreNot) {
  const Scene scene = courtyard();
  MeasureOptions options{.repeats = 1, .channels = Channel::Reflectance};
  options.intensity = [](const Shot&, const Hits& hits) {
    std::vector<float> intensity(hits.size(), 0.0f);
    for (std::size_t i = 0; i < hits.size(); ++i) intensity[i] = hits.reflectance[i] * hits.incidence[i];
    return intensity;
  };
  const std::vector<TrueShot> shots = trueShots(scene, twoShots(), options);
  ASSERT_EQ(shots.size(), 2u);
  EXPECT_EQ(shots[1].edges.size(), shots[1].truth.range.size());
  EXPECT_EQ(shots[1].intensity.size(), shots[1].truth.range.size());

  const Measurement rays = measure([&] { return rayTracing(scene); }, scene, shots, options);
  const GroupErrors& exact = rays.errors.all;
  EXPECT_EQ(exact.beams, 2u * 24 * 256);
  EXPECT_GT(exact.bothHit, 3000u);
  EXPECT_LT(exact.range.max, 1e-6);
  EXPECT_EQ(exact.missRate(), 0);
  EXPECT_EQ(exact.labels(), 1);
  EXPECT_EQ(exact.intensity.count, exact.bothHit);
  EXPECT_LT(exact.intensity.max, 1e-5);
  EXPECT_LT(exact.hausdorff(), 2e-6);
  EXPECT_EQ(exact.nearestTo.count, exact.bothHit);
  for (const SizeRecall& size : rays.errors.byThickness) EXPECT_EQ(size.instancesFound, size.instances) << size.name;

  const auto coarse = [&] {
    return methodOf("particle", scene, "{backend: cpu, refine: none, voxel_m: 0.4, voxels: 64}");
  };
  const Measurement particles = measure(coarse, scene, shots, options);
  EXPECT_GT(particles.errors.all.range.median, 0.01);
  EXPECT_GT(particles.errors.all.missRate(), 0);
  EXPECT_LT(particles.errors.all.labels(), 1);
  EXPECT_GT(particles.errors.all.nearestTo.mean, 0.01);
  EXPECT_GT(particles.cost.memoryBytes, 0u);
  // Silhouettes are where it errs.
  const GroupErrors& interior = particles.errors.byEdge[0].errors;
  const GroupErrors& edges = particles.errors.byEdge[1].errors;
  EXPECT_GT(edges.beams, 0u);
  EXPECT_GT(interior.beams, edges.beams);
  EXPECT_GT(edges.missRate() + 1 - edges.labels(), interior.missRate() + 1 - interior.labels());
}

TEST(Measure, ErrorsDoNotDependOnThreads) {
  const Scene scene = courtyard();
  const MeasureOptions options{.repeats = 1};
  const auto run = [&](int threads) {
    const ThreadLimit limit(threads);
    const std::vector<TrueShot> shots = trueShots(scene, twoShots(), options);
    const auto make = [&] { return methodOf("particle", scene, "{backend: cpu, voxel_m: 0.2}"); };
    return measure(make, scene, shots, options);
  };
  const Measurement one = run(1);
  const Measurement three = run(3);
  EXPECT_EQ(one.errors.all.range, three.errors.all.range);
  EXPECT_EQ(one.errors.byEdge[1].errors.beams, three.errors.byEdge[1].errors.beams);
  EXPECT_EQ(one.errors.byEdge[1].errors.nearestTo, three.errors.byEdge[1].errors.nearestTo);
}

// The points that a standing sensor's beams hit, in its own axes (m).
std::vector<Vec3f> pointsOf(const Shot& shot, const Hits& hits) {
  const BeamTable& beams = *shot.beams;
  std::vector<Vec3f> points;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits.hit(i)) continue;
    Vec3d p = beams.direction[i] * double{hits.range[i]};
    if (!beams.origin.empty()) p += Vec3d(beams.origin[i]);
    points.push_back(Vec3f(p));
  }
  return points;
}

TEST(HitPoints, AreWhereTheSensorPutsThem) {
  const Scene scene = courtyard();
  auto beams = spinning(8, 64, -25, 5, 15);
  beams->origin.assign(beams->size(), Vec3f{0.1f, 0.2f, 0.3f});
  const Shot shot = shotAt(beams, {fromYawPitchRoll(1, 0.1, 0.2), {0.3, -0.2, 0.1}});
  const Hits hits = traced(scene, shot);
  const std::vector<Vec3f> points = hitPoints(shot, hits);
  EXPECT_EQ(points, pointsOf(shot, hits));
  EXPECT_EQ(points.size(),
            static_cast<std::size_t>(std::ranges::count_if(hits.range, [](float r) { return r < kMiss; })));
  EXPECT_THROW(hitPoints(twoShots()[0], hits), Error);
}

TEST(HitPoints, OfAMovingSensorAreInTheFrameThatTheShotAsksFor) {
  const auto beams = spinning(1, 4, 0, 0);
  Shot shot = shotAt(beams, {fromYawPitchRoll(0.5, 0, 0), {1e6, 2e6, 0}});
  shot.worldFromSensor.push_back({fromYawPitchRoll(0.7, 0.1, 0), {1e6 + 1, 2e6 + 2, 0.5}});
  Hits hits;
  hits.reset(1, 4, Channel::Range);
  hits.range = {1, 2, 3, 4};
  EXPECT_EQ(hitPoints(shot, hits), pointsOf(shot, hits));
  shot.deskew = true;
  const std::vector<Vec3f> points = hitPoints(shot, hits);
  for (std::uint32_t i = 0; i < 4; ++i) {
    const Vec3d world = shot.worldFromSensor[i / 2] * (beams->direction[i] * double{hits.range[i]});
    const Vec3d expected = inverse(shot.worldFromSensor[0]) * world;
    EXPECT_LT(length(Vec3d(points[i]) - expected), 1e-6) << i;
  }
}

// Errors are computed by beam, so that several rays per beam would be compared with those of other beams.
TEST(Measure, RefusesSeveralRaysABeam) {
  Hits several;
  several.reset(1, 2, {});
  several.beamOfRay = {0, 1, 1};
  several.range = {10, 10, 12};
  EXPECT_THAT(messageOf<Error>([&] { requireOneRay(several); }), testing::HasSubstr("2 beams have 3 rays"));
}

// A disc of angular radius a seen head-on: edge beams are those whose angle to its rim is below the pixel's.
TEST(Measure, EdgesAreWhereNeighboursDiffer) {
  SceneBuilder builder = testBuilder();
  Mesh box = meshOf(builder, "thing");
  appendBox(box, 0, at(0, 0, 0), {0.02, 2, 2});
  builder.place(builder.addMesh(box), at(10, 0, 0), "board");
  const Scene scene = builder.finish();
  const auto method = rayTracing(scene);
  const double angle = 0.002;
  const Shot shot = shotAt(spinning(9, 3600, -8, 8));
  const std::vector<std::uint8_t> edges = edgeBeams(*method, shot, angle);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Vec3d& d = shot.beams->direction[i];
    if (d.x <= 0) {
      EXPECT_EQ(edges[i], 0);
      continue;
    }
    // Distance, on the image plane at 1 m, from the square's outline of half side 1 / 9.99.
    const double u = std::abs(d.y / d.x);
    const double v = std::abs(d.z / d.x);
    const double half = 1 / 9.99;
    const double toOutline = u <= half && v <= half ? std::min(half - u, half - v)
                                                    : std::hypot(std::max(u - half, 0.0), std::max(v - half, 0.0));
    if (toOutline > 2.1 * angle) {
      EXPECT_EQ(edges[i], 0) << u << " " << v;
    }
    if (toOutline < 0.9 * angle) {
      EXPECT_EQ(edges[i], 1) << u << " " << v;
    }
  }
  EXPECT_GT(std::accumulate(edges.begin(), edges.end(), 0), 15);
}

}  // namespace
}  // namespace scanmill
