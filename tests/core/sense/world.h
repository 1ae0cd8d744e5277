#pragma once

// Hits as tests want them: a sensor on a grid of azimuths and elevations, with chosen ranges.

#include <memory>
#include <string>
#include <vector>

#include "base/random.h"
#include "sense/sense.h"
#include "tests/support/message_of.h"

namespace scanmill {

struct World {
  Shot shot;
  Hits hits;
  std::vector<Material> materials;

  BeamTable& beams() { return const_cast<BeamTable&>(*shot.beams); }
};

// Every beam meets a white matt wall at normal incidence, `range` metres away.
inline World makeWorld(std::uint32_t rings, std::uint32_t columns, float range = 10) {
  World world;
  const auto beams = std::make_shared<BeamTable>();
  beams->rings = rings;
  beams->columns = columns;
  for (std::uint32_t ring = 0; ring < rings; ++ring) {
    const double elevation = rings == 1 ? 0.0 : radians(-30.0 + 60.0 * ring / (rings - 1));
    for (std::uint32_t column = 0; column < columns; ++column) {
      const double azimuth = 2 * kPi * column / columns;
      beams->direction.push_back(
          {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)});
      beams->time.push_back(static_cast<float>(0.1 * column / columns + 1e-5 * ring));
    }
  }
  world.shot.seed = 2024;
  world.shot.beams = beams;
  world.shot.worldFromSensor.resize(1);
  world.materials.resize(1);
  world.materials[0].reflectance = 1;
  Hits& hits = world.hits;
  hits.reset(rings, columns, Channels::all());
  std::fill(hits.range.begin(), hits.range.end(), range);
  std::fill(hits.reflectance.begin(), hits.reflectance.end(), 1.0f);
  std::fill(hits.incidence.begin(), hits.incidence.end(), 1.0f);
  for (std::uint32_t beam = 0; beam < hits.size(); ++beam) {
    hits.semantic[beam] = static_cast<std::uint16_t>(1 + beam % 1000);
    hits.instance[beam] = 100 + beam;
    hits.material[beam] = 0;
  }
  return world;
}

// Returns a world as makeWorld() does, with beams of 3 mrad, pulses of 5 ns and a range of 1 to 100 m.
inline World makeWideWorld(std::uint32_t rings, std::uint32_t columns, float range) {
  World world = makeWorld(rings, columns, range);
  world.beams().minRange = 1;
  world.beams().maxRange = 100;
  world.beams().divergence = {3e-3, 3e-3};
  world.beams().pulse = 5e-9;
  return world;
}

inline void miss(World& world, std::size_t beam) {
  world.hits.range[beam] = kMiss;
  world.hits.semantic[beam] = 0;
  world.hits.instance[beam] = 0;
  world.hits.reflectance[beam] = 0;
  world.hits.incidence[beam] = 0;
}

// Ranges of 1 to 80 m, a third of the beams misses, in no order.
inline World makeRaggedWorld(std::uint32_t rings, std::uint32_t columns) {
  World world = makeWorld(rings, columns);
  for (std::uint32_t beam = 0; beam < world.hits.size(); ++beam) {
    const RandomBlock random = randomBlock({.seed = 11, .beam = beam});
    world.hits.range[beam] = static_cast<float>(1 + 79 * uniform(random[0]));
    if (random[1] % 3 == 0) miss(world, beam);
  }
  return world;
}

// From "range_noise: {sigma_m: 0.02}".
inline std::unique_ptr<Effect> makeEffect(const std::string& yaml) {
  const Value value = parseYaml(yaml, "test.yaml");
  const auto& [name, options] = value.entries.front();
  Fields fields(options, "effect " + name);
  return requireEffect(name, value.where).make(fields);
}

inline Effects makeEffects(const std::vector<std::string>& yaml) {
  Effects made;
  for (const std::string& text : yaml) made.push_back({nullptr, makeEffect(text), {}});
  return made;
}

inline Returns runEffects(const World& world, const Effects& effects) {
  Returns returns;
  detect(world.hits, world.shot, effects, world.materials, returns);
  for (const auto& effect : effects) effect->apply(world.hits, world.shot, world.materials, returns);
  return returns;
}

inline Returns run(const World& world, const std::vector<std::string>& yaml) {
  return runEffects(world, makeEffects(yaml));
}

inline Scan senseOnce(const World& world, const std::vector<std::string>& yaml, const ScanLayout& layout = {}) {
  Returns scratch;
  Scan scan;
  const Effects effects = makeEffects(yaml);
  sense({effects, world.materials, layout}, world.hits, world.shot, scratch, scan);
  return scan;
}

// Effects of every stage.
inline const std::vector<std::string> kManyEffects{
    "intensity: {gain: 3}",         "dropout: {threshold: 0.01, probability: 0.05}",
    "range_noise: {sigma_m: 0.02}", "shell: {growth_per_m: 0.01}",
    "quantize: {step_m: 0.008}",    "angular_jitter: {sigma_deg: 0.02}"};

inline std::string refusal(const std::string& yaml) {
  return messageOf([&] { makeEffect(yaml); });
}

struct Moments {
  double mean = 0;
  double variance = 0;
  double skewness = 0;
  double kurtosis = 0;
};

inline Moments momentsOf(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  Moments m;
  for (double v : values) m.mean += v / n;
  double third = 0;
  double fourth = 0;
  for (double v : values) {
    const double d = v - m.mean;
    m.variance += d * d / n;
    third += d * d * d / n;
    fourth += d * d * d * d / n;
  }
  m.skewness = third / std::pow(m.variance, 1.5);
  m.kurtosis = fourth / (m.variance * m.variance);
  return m;
}

inline double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const Moments ma = momentsOf(a);
  const Moments mb = momentsOf(b);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - ma.mean) * (b[i] - mb.mean);
  return sum / static_cast<double>(a.size()) / std::sqrt(ma.variance * mb.variance);
}

}  // namespace scanmill
