#pragma once

// Scans of the procedural street by a method and by ray tracing in the same run.

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "tests/benchmarks/street_beams.h"
#include "tests/benchmarks/timing.h"
#include "tests/core/methods/trace.h"
#include "tests/support/street.h"

namespace scanmill {

inline const Scene& street() {
  static const Scene scene = proceduralStreet();
  return scene;
}

inline constexpr Channels kTracedChannels = Channels(Channel::Range) | Channel::Normal | Channel::Instance |
                                            Channel::Semantic | Channel::Material | Channel::Reflectance |
                                            Channel::Incidence;

// Counters: the seconds of the method's stages in milliseconds a scan, its beams a second, and its time over that of
// ray tracing. The benchmark's argument is the number of rings.
inline void scanAgainstRayTracing(benchmark::State& state, const std::string& method, const std::string& options) {
  const Shot shot = streetShot(streetBeams(state.range(0)), -20);
  const auto tested = methodOf(method, street(), options);
  const auto tracing = rayTracing(street());
  Hits hits;
  TraceAccount account;
  const auto ours = [&] { account += tested->trace(shot, kTracedChannels, hits); };
  const auto traced = [&] { tracing->trace(shot, kTracedChannels, hits); };
  ours();
  traced();
  std::vector<double> oursSeconds;
  std::vector<double> tracedSeconds;
  account = {};
  std::size_t scans = 0;
  for (auto _ : state) {
    const std::vector<double> each = secondsOfEach(5, ours);
    scans += each.size();
    oursSeconds.push_back(median(each));
    state.SetIterationTime(oursSeconds.back());
    tracedSeconds.push_back(median(secondsOfEach(5, traced)));
  }
  for (const auto& [stage, seconds] : account.seconds) {
    state.counters[stage + "_ms"] = 1e3 * seconds / static_cast<double>(scans);
  }
  state.counters["beams/s"] = static_cast<double>(hits.size()) / median(oursSeconds);
  state.counters["of_ray_tracing"] = median(oursSeconds) / median(tracedSeconds);
}

// Runs scan(state, options) with 64 and 512 rings.
#define SCANS(name, options)             \
  BENCHMARK_CAPTURE(scan, name, options) \
      ->Arg(64)                          \
      ->Arg(512)                         \
      ->UseManualTime()                  \
      ->Iterations(5)                    \
      ->Unit(benchmark::kMillisecond)

}  // namespace scanmill
