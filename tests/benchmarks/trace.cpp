// Our trace stage, with all columns, against bare Embree on the same triangles, beams and threads. The counter
// `of_bare` is the ratio of both times in one run; 64 x 2048 beams into 1.2 million triangles.

#include "tests/core/methods/trace.h"

#include <benchmark/benchmark.h>

#include "base/random.h"
#include "sense/sense.h"
#include "sensors/footprint.h"
#include "tests/benchmarks/bare_embree.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/effects_of.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

// Rolling ground of half a million triangles and 350 spheres of 2,000.
Scene bigScene() {
  SceneBuilder builder = testBuilder();
  Mesh ground = meshOf(builder, "ground");
  appendPlane(ground, 0, {}, 200, 200, 500);
  for (Vec3f& p : ground.positions) p.z = 0.2f * std::sin(p.x * 0.12f) * std::cos(p.y * 0.17f) - 1.8f;
  builder.place(builder.addMesh(ground), {}, "ground");
  for (std::uint32_t i = 0; i < 350; ++i) {
    const RandomBlock b = randomBlock({3, 0, 0, 0, i, 0, Purpose::Test});
    Mesh sphere = meshOf(builder, "thing");
    appendSphere(sphere, 0, {}, 0.5 + 1.5 * uniform(b[3]), 46);
    const double x = 180 * uniform(b[0]) - 90;
    const double y = 180 * uniform(b[1]) - 90;
    builder.place(builder.addMesh(sphere), at(x + (x * x + y * y < 16 ? 8 : 0), y, 3 * uniform(b[2]) - 1), "sphere");
  }
  return builder.finish();
}

const Scene& scene() {
  static const Scene made = bigScene();
  return made;
}

void traceAgainstBare(benchmark::State& state) {
  const auto rings = static_cast<std::uint32_t>(state.range(0));
  const auto beams = spinning(rings, 2048, -24.8, 2, 120);
  const auto method = rayTracing(scene());
  const Shot shot = shotAt(beams);
  Hits hits;
  BareEmbree bare(scene(), *beams);
  const auto ours = [&] { method->trace(shot, Channels::all(), hits); };
  ours();
  for (std::size_t order : {0, 1}) bare.trace(order);
  std::vector<double> oursSeconds;
  std::vector<double> bareSeconds[2];
  // Each in blocks, as a dataset is made: frame after frame with the caches to itself.
  for (auto _ : state) {
    const double seconds = median(secondsOfEach(10, ours));
    oursSeconds.push_back(seconds);
    state.SetIterationTime(seconds);
    for (std::size_t order : {0, 1}) {
      bareSeconds[order].push_back(median(secondsOfEach(10, [&] { bare.trace(order); })));
    }
  }
  const double best = std::min(median(bareSeconds[0]), median(bareSeconds[1]));
  const auto rays = static_cast<double>(beams->size());
  state.counters["rays/s"] = rays / median(oursSeconds);
  state.counters["bare_rays/s"] = rays / best;
  state.counters["of_bare"] = best / median(oursSeconds);
}
BENCHMARK(traceAgainstBare)->Arg(64)->Arg(512)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(20);

// Beams of finite width: the time of a ray of a footprint over that of a beam of one ray, both traced, with what the
// effects read; and the rate of whole pulses, from rays to the echoes' returns.
void footprintAgainstBeams(benchmark::State& state) {
  const auto beams = spinning(64, 2048, -24.8, 2, 120);
  beams->divergence = {0.003, 0.003};
  beams->pulse = 5e-9;
  const Footprint footprint = makeFootprint(*beams, static_cast<std::uint32_t>(state.range(0)));
  const auto method = rayTracing(scene());
  const Shot shot = shotAt(beams);
  Shot wide = shot;
  wide.beams = footprint.rays;
  const Channels channels = Channel::Range | Channel::Semantic | Channels(Channel::Instance) | Channel::Material |
                            Channel::Reflectance | Channel::Incidence;
  const Effects effects = effectsOf(parseYaml("[{intensity: {}}, {detection: {}}]", "benchmark"));
  Hits hits;
  Returns returns;
  Scan scan;
  const auto narrow = [&] { method->trace(shot, channels, hits); };
  const auto traced = [&] {
    method->trace(wide, channels, hits);
    joinRays(footprint, hits);
  };
  const auto whole = [&] {
    traced();
    sense({effects, scene().materials}, hits, shot, returns, scan);
  };
  whole();
  narrow();
  std::vector<double> narrowSeconds;
  std::vector<double> tracedSeconds;
  std::vector<double> wholeSeconds;
  for (auto _ : state) {
    narrowSeconds.push_back(median(secondsOfEach(5, narrow)));
    tracedSeconds.push_back(median(secondsOfEach(3, traced)));
    wholeSeconds.push_back(median(secondsOfEach(3, whole)));
    state.SetIterationTime(wholeSeconds.back());
  }
  const auto count = static_cast<double>(beams->size());
  state.counters["pulses/s"] = count / median(wholeSeconds);
  state.counters["ray_of_beam"] = median(tracedSeconds) / (static_cast<double>(state.range(0)) * median(narrowSeconds));
}
BENCHMARK(footprintAgainstBeams)->Arg(7)->Arg(19)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(10);

}  // namespace
}  // namespace scanmill
