// The particle method, stage by stage, on the procedural street (1.3 million placed triangles): building the
// field, moving it, flying 64 or 512 x 2048 particles. `of_*` are ratios of times in one run.

#include "methods/particle/particle.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "methods/field/build.h"
#include "methods/particle/march.h"
#include "methods/particle/shape.h"
#include "methods/world/worlds.h"
#include "tests/benchmarks/against_ray_tracing.h"
#include "tests/benchmarks/timing.h"
#include "tests/core/methods/trace.h"
#include "tests/support/street.h"

namespace scanmill {
namespace {

constexpr double kRange = 120;  // m

struct Place {
  std::shared_ptr<const World> world;
  FieldShape shape;
};

Place placeAt(double x, bool lists) {
  static const Worlds worlds(street(), Instancing::Never, {});
  ParticleOptions options;
  options.refine = lists ? ParticleOptions::Refine::ByTriangle : ParticleOptions::Refine::None;
  const Vec3d sensor{x, -1.75, 1.9};
  const auto world = worlds.near(sensor);
  Box scene = street().bounds();
  scene = {scene.low - world->origin, scene.high - world->origin};
  return {world, shapeOf(options, sensor - world->origin, scene, kRange)};
}

// A whole field, and what moving it by a metre takes.
void field(benchmark::State& state, bool lists) {
  const Place here = placeAt(-20, lists);
  std::shared_ptr<const DistanceField> built;
  std::vector<double> build;
  std::vector<double> update;
  for (auto _ : state) {
    build.push_back(secondsOf([&] { built = buildField(*here.world, here.shape); }));
    state.SetIterationTime(build.back());
    // Moves are of whole bricks of 0.8 m and more; averaged over ten metres.
    std::shared_ptr<const DistanceField> at = built;
    update.push_back(secondsOf([&] {
                       for (int metre = 1; metre <= 10; ++metre) {
                         at = buildField(*here.world, placeAt(-20 + metre, lists).shape, {at});
                       }
                     }) /
                     10);
  }
  state.counters["MB"] = 1e-6 * static_cast<double>(4 * built->table.size() + built->distance.size_bytes() +
                                                    built->word.size_bytes() + built->lists.size_bytes());
  state.counters["full_bricks"] = static_cast<double>(built->distance.size() / kBrickStride);
  state.counters["update_ms"] = 1e3 * median(update);
  state.counters["update_of_build"] = median(update) / median(build);
}
#define FIELDS(name, lists) \
  BENCHMARK_CAPTURE(field, name, lists)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond)
FIELDS(nearest, false);
FIELDS(lists, true);

// The field being there. Stages are of the processor's time.
void scan(benchmark::State& state, const std::string& options) {
  scanAgainstRayTracing(state, "particle", "{" + options + "}");
}
SCANS(none, "refine: none");
SCANS(normal, "refine: normal");
SCANS(triangle, "refine: triangle");

// A sensor that drives on by a metre from scan to scan, 64 x 2048 beams: its field moves along. Stages in milliseconds
// a scan.
void drive(benchmark::State& state, const std::string& options) {
  const auto particle = methodOf("particle", street(), "{" + options + "}");
  const auto beams = streetBeams(64);
  Hits hits;
  const auto scanAt = [&](double x) { return particle->trace(streetShot(beams, x), kTracedChannels, hits); };
  TraceAccount account;
  std::vector<double> seconds;
  constexpr int kMetres = 10;
  double x = -30;
  scanAt(x);
  for (auto _ : state) {
    const double each = secondsOf([&] {
                          for (int metre = 0; metre < kMetres; ++metre) account += scanAt(++x);
                        }) /
                        kMetres;
    seconds.push_back(each);
    state.SetIterationTime(each);
  }
  for (const auto& [stage, sum] : account.seconds) {
    state.counters[stage + "_ms"] = 1e3 * sum / static_cast<double>(kMetres * seconds.size());
  }
}
#define DRIVES(name, options) \
  BENCHMARK_CAPTURE(drive, name, options)->UseManualTime()->Iterations(3)->Unit(benchmark::kMillisecond)
DRIVES(none, "refine: none");
DRIVES(triangle, "refine: triangle");

}  // namespace
}  // namespace scanmill
