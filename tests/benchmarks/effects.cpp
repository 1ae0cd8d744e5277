// Time of each effect and of sense(), per beam, on one core: 128 rings x 1024 columns of which a third misses.

#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <string>

#include "base/random.h"
#include "sense/sense.h"
#include "tests/support/effects_of.h"

namespace scanmill {
namespace {

struct Room {
  Shot shot;
  Hits hits;
  std::vector<Material> materials;
};

Room makeRoom(std::uint32_t rings, std::uint32_t columns) {
  Room room;
  auto beams = std::make_shared<BeamTable>();
  beams->rings = rings;
  beams->columns = columns;
  beams->maxRange = 120;
  beams->minRange = 1;
  beams->pulse = 5e-9;
  beams->divergence = {0.003, 0.003};
  room.materials.resize(40);
  for (std::size_t m = 0; m < room.materials.size(); ++m) {
    room.materials[m].roughness = 0.3f + 0.015f * static_cast<float>(m);
    room.materials[m].variations = {{3, 0.1f}, {0.2f, 0.1f}};
    if (m % 2 == 0) room.materials[m].relief = {{0.1f, 0.02f}};
  }
  room.hits.reset(rings, columns, Channels::all());
  for (std::uint32_t ring = 0; ring < rings; ++ring) {
    const double elevation = radians(22.5 - 45.0 * ring / rings);
    for (std::uint32_t column = 0; column < columns; ++column) {
      const double azimuth = 2 * kPi * column / columns;
      beams->direction.push_back(
          {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)});
      beams->time.push_back(static_cast<float>(0.1 * column / columns));
      const std::size_t beam = std::size_t{ring} * columns + column;
      const RandomBlock random = randomBlock({.seed = 5, .beam = static_cast<std::uint32_t>(beam)});
      const bool miss = ring < rings / 3 && random[0] % 16 != 0;
      room.hits.range[beam] = miss ? kMiss : static_cast<float>(5 + 60 * uniform(random[1]));
      room.hits.semantic[beam] = static_cast<std::uint16_t>(miss ? 0 : random[2] % 20);
      room.hits.instance[beam] = miss ? 0 : random[2] % 1000;
      room.hits.material[beam] = static_cast<std::uint16_t>(miss ? 0 : random[3] % 40);
      room.hits.reflectance[beam] = miss ? 0 : 0.3f;
      room.hits.incidence[beam] = miss ? 0 : static_cast<float>(uniform(random[3]));
    }
  }
  room.shot.beams = std::move(beams);
  room.shot.worldFromSensor.resize(1);
  return room;
}

void report(benchmark::State& state, const Hits& hits) {
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * hits.size()));
  state.counters["ns_per_beam"] =
      benchmark::Counter(1e-9 * static_cast<double>(hits.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void effectAlone(benchmark::State& state, const std::string& yaml) {
  const Room room = makeRoom(128, 1024);
  const Effects list = effectsOf(parseYaml(yaml, "benchmark"));
  Returns returns;
  for (auto _ : state) {
    returns.start(room.hits);
    for (const auto& effect : list) effect->apply(room.hits, room.shot, room.materials, returns);
    benchmark::ClobberMemory();
  }
  report(state, room.hits);
}

void wholeSense(benchmark::State& state, const std::string& yaml, bool organised, std::size_t steps,
                std::uint32_t rings, std::uint32_t columns) {
  Room room = makeRoom(rings, columns);
  room.shot.worldFromSensor.resize(steps);
  for (std::size_t s = 0; s < steps; ++s) room.shot.worldFromSensor[s].translation.x = 1e-3 * static_cast<double>(s);
  room.shot.deskew = steps > 1;
  const Effects list = effectsOf(parseYaml(yaml, "benchmark"));
  Returns scratch;
  Scan scan;
  for (auto _ : state) {
    sense({list, room.materials, {.organised = organised}}, room.hits, room.shot, scratch, scan);
    benchmark::ClobberMemory();
  }
  report(state, room.hits);
}

const std::string kNone = "[]";
const std::string kUsual = "[{intensity: {}}, {range_noise: {sigma_m: 0.02}}]";
const std::string kEverything =
    "[{intensity: {attenuation_per_m: 0.001, output: u8}}, {dropout: {threshold: 0.001, probability: 0.01}}, "
    "{range_noise: {sigma_m: 0.02}}, {quantize: {step_m: 0.008}}, {angular_jitter: {sigma_deg: 0.01}}]";

BENCHMARK_CAPTURE(effectAlone, copy, kNone);
BENCHMARK_CAPTURE(effectAlone, intensity, "[{intensity: {}}]");
BENCHMARK_CAPTURE(effectAlone, intensity_air_gamma_u8,
                  "[{intensity: {attenuation_per_m: 0.001, gamma: 0.5, output: u8}}]");
BENCHMARK_CAPTURE(effectAlone, intensity_reflectivity,
                  "[{intensity: {model: reflectivity, diffuse: oren_nayar, output: u8, gamma: 0.5}}]");
BENCHMARK_CAPTURE(effectAlone, intensity_by_manual,
                  "[{intensity: {model: reflectivity, diffuse: oren_nayar, output: u8, retro_full_scale: 1000}}]");
BENCHMARK_CAPTURE(effectAlone, speckle_4, "[{speckle: {looks: 4}}]");
BENCHMARK_CAPTURE(effectAlone, speckle_20, "[{speckle: {looks: 20}}]");
BENCHMARK_CAPTURE(effectAlone, ring_bias,
                  "[{ring_bias: {range_sigma_m: 0.03, elevation_sigma_deg: 0.18, gain_sigma: 0.35}}]");
BENCHMARK_CAPTURE(effectAlone, reflectance_variation, "[{reflectance_variation: {}}]");
BENCHMARK_CAPTURE(effectAlone, relief, "[{relief: {}}]");
BENCHMARK_CAPTURE(effectAlone, rain, "[{weather: {kind: rain, severity: moderate, wet: 0}}]");
BENCHMARK_CAPTURE(effectAlone, rain_on_wet_ground, "[{weather: {kind: rain, severity: moderate}}]");
BENCHMARK_CAPTURE(effectAlone, snow, "[{weather: {kind: snow, severity: moderate}}]");
BENCHMARK_CAPTURE(effectAlone, fog, "[{weather: {kind: fog, severity: moderate}}]");
BENCHMARK_CAPTURE(effectAlone, intensity_detection, "[{intensity: {}}, {detection: {noise: 0.0008}}]");
BENCHMARK_CAPTURE(effectAlone, dropout, "[{dropout: {probability: 0.05}}]");
BENCHMARK_CAPTURE(effectAlone, range_noise, "[{range_noise: {sigma_m: 0.02, sigma_per_m: 0.001}}]");
BENCHMARK_CAPTURE(effectAlone, range_noise_table, "[{range_noise: {table: [[1, 0.03], [20, 0.01], [100, 0.05]]}}]");
BENCHMARK_CAPTURE(effectAlone, shell, "[{shell: {growth_per_m: 0.01}}]");
BENCHMARK_CAPTURE(effectAlone, quantize, "[{quantize: {step_m: 0.008}}]");
BENCHMARK_CAPTURE(effectAlone, angular_jitter, "[{angular_jitter: {sigma_deg: 0.01}}]");
BENCHMARK_CAPTURE(wholeSense, bare, kNone, false, 1, 128, 1024);
BENCHMARK_CAPTURE(wholeSense, bare_organised, kNone, true, 1, 128, 1024);
BENCHMARK_CAPTURE(wholeSense, bare_64x2048, kNone, false, 1, 64, 2048);
BENCHMARK_CAPTURE(wholeSense, bare_2048x2048, kNone, false, 1, 2048, 2048);
BENCHMARK_CAPTURE(wholeSense, bare_deskew, kNone, false, 1024, 128, 1024);
BENCHMARK_CAPTURE(wholeSense, usual, kUsual, false, 1, 128, 1024);
BENCHMARK_CAPTURE(wholeSense, everything, kEverything, false, 1, 128, 1024);

}  // namespace
}  // namespace scanmill

BENCHMARK_MAIN();
