#include "sense/weather.h"

#include <fmt/format.h>

#include <map>

#include "sensors/footprint.h"
#include "sensors/sensor.h"
#include "tests/core/sense/several_returns.h"
#include "tests/support/effects_of.h"

namespace scanmill {
namespace {

World wallAt(float range) {
  return makeWideWorld(64, 1000, range);
}

World sky(std::uint32_t columns = 1000) {
  World world = makeWideWorld(64, columns, kMiss);
  for (std::size_t beam = 0; beam < world.hits.size(); ++beam) miss(world, beam);
  return world;
}

// How many drops that send back `least` or more a beam is expected to meet up to a range, by sums. `near`:
// near_range_m.
double expectedDrops(const Weather& weather, const BeamTable& beams, double least, double near, double until) {
  double sum = 0;
  const double step = 1e-3;
  for (double r = beams.minRange + step / 2; r < until; r += step) {
    const double area = beamArea(beams, r);
    const double way = std::max(r, near) / 10;
    const double d2 = least * area / weather.dropEcho * way * way * std::exp(2 * weather.extinction * r);
    sum += area * weather.drops.above(std::sqrt(d2)) * step;
  }
  return sum;
}

std::vector<std::uint32_t> particles(const Returns& returns) {
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < returns.size(); ++row) {
    if (returns.returned(row) && returns.cause(row) == Reason::Weather) rows.push_back(row);
  }
  return rows;
}

TEST(WeatherEffect, DropsAreAsManyAsTheLawOfTheirSizesSays) {
  const World world = sky();
  for (const bool snow : {false, true}) {
    const Weather weather = snow ? snowOf(2) : rainOf(40);
    const double near = snow ? 3 : 1;
    const Returns returns =
        snow ? run(world, {"weather: {kind: snow, rate_mm_h: 2, least: 0.01}", "intensity: {near_range_m: 3}"})
             : run(world, {"weather: {kind: rain, rate_mm_h: 40, least: 0.0005}", "intensity: {}"});
    const double mean = expectedDrops(weather, *world.shot.beams, snow ? 0.01 : 0.0005, near, 100);
    const double n = static_cast<double>(world.hits.size());
    ASSERT_GT(mean, 0.05);
    ASSERT_LT(mean, 2);
    const std::vector<std::uint32_t> rows = particles(returns);
    EXPECT_NEAR(static_cast<double>(rows.size()), n * mean, 4 * std::sqrt(n * mean)) << snow;
    std::vector<double> perBeam(world.hits.size());
    for (const std::uint32_t row : rows) perBeam[returns.beam(row)] += 1;
    EXPECT_NEAR(momentsOf(perBeam).variance / mean, 1, 0.05) << snow;  // Poisson's law
    // As many as expected up to a few metres too.
    for (const double until : {2.0, 4.0, 7.0}) {
      const double some = expectedDrops(weather, *world.shot.beams, snow ? 0.01 : 0.0005, near, until);
      const auto nearer = std::count_if(rows.begin(), rows.end(),
                                        [&](std::uint32_t row) { return double{returns.range[row]} < until; });
      EXPECT_NEAR(static_cast<double>(nearer), n * some, 4 * std::sqrt(n * some)) << snow << " " << until;
    }
  }
}

TEST(WeatherEffect, NoDropIsFainterThanTheLeastOrBehindASurface) {
  const World world = wallAt(6);
  const Returns returns = run(world, {"weather: {kind: snow, rate_mm_h: 4, least: 0.01, label: 77}", "intensity: {}"});
  const std::vector<std::uint32_t> rows = particles(returns);
  ASSERT_GT(rows.size(), 100u);
  for (const std::uint32_t row : rows) {
    EXPECT_GE(returns.power[row], 0.01f * 0.999f);
    EXPECT_GE(returns.range[row], 1);
    EXPECT_LE(returns.range[row], 6);
    EXPECT_EQ(returns.hit(row), kNoHit);
    EXPECT_EQ(returns.label[row], 77);
    EXPECT_EQ(returns.instance[row], 0u);
  }
}

TEST(WeatherEffect, LightIsLostAsBeerAndLambertSay) {
  const World world = wallAt(40);
  const Returns clear = run(world, {"intensity: {}"});
  for (const std::string kind : {"fog, visibility_m: 60", "dust, visibility_m: 60", "rain, rate_mm_h: 30, wet: 0"}) {
    const double extinction = kind[0] == 'r' ? rainOf(30).extinction : fogOf(60).extinction;
    const Returns dim = run(world, {"weather: {kind: " + kind + "}", "intensity: {model: reflectivity}"});
    for (std::size_t row = 0; row < world.hits.size(); ++row) {
      ASSERT_NEAR(dim.power[row] / clear.power[row], std::exp(-2 * extinction * 40), 1e-6) << kind;
      ASSERT_NEAR(dim.intensity[row], std::exp(-2 * extinction * 40), 1e-6) << kind;  // the sensor knows nothing of it
    }
  }
}

// The lidar equation of a soft target that fills the beam, whose power is constant nearer than near_range_m.
TEST(WeatherEffect, FogHasThePowerOfTheLidarEquation) {
  const World world = sky();
  const Weather fog = fogOf(50);
  const double length = pulseLength(5e-9);
  for (const double near : {1.0, 4.0}) {
    const Returns returns = run(world, {"weather: {kind: fog, visibility_m: 50, least: 0.008}",
                                        "intensity: {near_range_m: " + std::to_string(near) + "}"});
    const auto power = [&](double r) {
      const double way = 10 / std::max(r, near);
      return kPi * fog.extinction / 18.8 * length * way * way * std::exp(-2 * fog.extinction * r);
    };
    const std::vector<std::uint32_t> rows = particles(returns);
    std::map<int, int> perInterval;
    for (const std::uint32_t row : rows) {
      const double r = double{returns.range[row]};
      ASSERT_NEAR(returns.power[row] / power(r), 1, 1e-5) << r;
      ASSERT_GE(returns.power[row], 0.008f * 0.99999f);
      ++perInterval[static_cast<int>((r - 1) / length)];
    }
    // Every interval whose power exceeds the least at its far end has a return in every beam.
    int certain = 0;
    while (power(1 + (certain + 1) * length) > 0.008) ++certain;
    ASSERT_GT(certain, 3);
    ASSERT_LE(certain, 7);
    for (int k = 0; k < certain; ++k) EXPECT_EQ(perInterval[k], static_cast<int>(world.hits.size())) << near;
  }
}

// The least power follows the receiver's threshold: haze has a power of 0.0004 here.
TEST(WeatherEffect, ReceiversThatDetectLessReportMoreFog) {
  const World world = sky(100);
  const auto share = [&](const std::string& noise) {
    const Returns returns = run(world, {"weather: {kind: fog, visibility_m: 1000}", "intensity: {near_range_m: 10}",
                                        "detection: {noise: " + noise + "}"});
    return static_cast<double>(particles(returns).size()) / static_cast<double>(world.hits.size());
  };
  EXPECT_EQ(share("0.001"), 0.0);
  EXPECT_GT(share("0.00004"), 0.99);
}

// The thresholds of detection are in the units of power of the intensity, such as that of a white target at 5 m.
TEST(WeatherEffect, WhatIsIgnoredDoesNotDependOnTheUnitOfPower) {
  const World world = sky(100);
  const auto ranges = [&](const std::string& weather, const std::string& intensity, const std::string& noise) {
    const Returns returns = run(
        world, {"weather: " + weather, "intensity: " + intensity, "detection: {threshold: 5, noise: " + noise + "}"});
    std::vector<float> found;
    for (const std::uint32_t row : particles(returns)) found.push_back(returns.range[row]);
    return found;
  };
  for (const std::string weather : {"{kind: snow, rate_mm_h: 2}", "{kind: fog, visibility_m: 200}"}) {
    const std::vector<float> usual = ranges(weather, "{reference_range_m: 10}", "0.00004");
    ASSERT_GT(usual.size(), 100u);
    const std::vector<float> other = ranges(weather, "{reference_range_m: 5}", "0.00001");
    EXPECT_EQ(usual, other) << weather;
  }
  // An echo of 0.0008 of a white target at its range, twice the threshold, at any range.
  const std::vector<float> even = ranges("{kind: fog, visibility_m: 500}", "{falloff: none}", "0.00008");
  ASSERT_FALSE(even.empty());
  EXPECT_GT(*std::max_element(even.begin(), even.end()), 20);
}

// Nearer than near_range_m the power hardly changes with the range: a beam's eight returns are anywhere in there.
TEST(WeatherEffect, FogOfANearRangeIsAnywhereWithinIt) {
  const Returns returns =
      run(sky(), {"weather: {kind: fog, visibility_m: 1000, least: 0.00001}", "intensity: {near_range_m: 20}"});
  std::vector<double> ranges;
  for (const std::uint32_t row : particles(returns)) {
    if (returns.range[row] < 19) ranges.push_back(double{returns.range[row]});
  }
  EXPECT_NEAR(momentsOf(ranges).mean, 10, 0.5);
}

TEST(WeatherEffect, ThePowerOfParticlesFallsOffAndTheirReflectivityDoesNot) {
  const World world = sky();
  const std::string snow = "weather: {kind: snow, rate_mm_h: 2, least: 0.01}";
  const Returns power = run(world, {snow, "intensity: {}"});
  const Returns corrected = run(world, {snow, "intensity: {model: reflectivity}"});
  ASSERT_FALSE(particles(power).empty());
  for (const std::uint32_t row : particles(power)) {
    const double way = 10 / double{power.range[row]};
    EXPECT_EQ(power.power[row], corrected.power[row]);
    EXPECT_NEAR(power.intensity[row] / (corrected.intensity[row] * way * way), 1, 1e-5);
  }
}

// A floor below, seen from 2 m.
TEST(WeatherEffect, AShareOfTheGroundLiesUnderWater) {
  World world = wallAt(10);
  Hits& hits = world.hits;
  for (std::size_t beam = 0; beam < hits.size(); ++beam) {
    hits.normal[beam] = {0, 0, 1};
    hits.reflectance[beam] = 0.13f;
    hits.incidence[beam] = 0.2f;
    hits.range[beam] = static_cast<float>(3 + 60.0 * static_cast<double>(beam / 1000) / 64);
  }
  for (const double share : {0.2, 0.7}) {
    const Returns returns =
        run(world, {"weather: {kind: rain, rate_mm_h: 0.01, wet: " + std::to_string(share) + ", least: 1}"});
    double film = 0;
    for (std::size_t row = 0; row < hits.size(); ++row) {
      const double left = returns.gain[row] / std::exp(-2 * rainOf(0.01).extinction * double{hits.range[row]});
      const bool wet = left < dampness(0.13) * 0.99;
      ASSERT_NEAR(left, dampness(0.13f) * (wet ? filmTransmission(0.2f) : 1), 1e-5);
      film += wet ? 1 : 0;
    }
    EXPECT_NEAR(film / static_cast<double>(hits.size()), share, 0.06);
  }
  std::fill(hits.normal.begin(), hits.normal.end(), Vec3f{1, 0, 0});
  for (const float gain : run(world, {"weather: {kind: rain, rate_mm_h: 0.01, least: 1}"}).gain) EXPECT_GT(gain, 0.99f);
}

TEST(WeatherEffect, BeamsThatTheEgoVehicleBlocksStayEmpty) {
  World world = sky();
  world.hits.pathOfRay.assign(world.hits.size(), RayPath::Direct);
  for (std::size_t beam = 0; beam < world.hits.size(); beam += 2) world.hits.pathOfRay[beam] = RayPath::EgoVehicle;
  const Returns returns = run(world, {"weather: {kind: snow, severity: heavy}"});
  ASSERT_GT(particles(returns).size(), 1000u);
  for (const std::uint32_t row : particles(returns)) EXPECT_EQ(returns.beam(row) % 2, 1u);
}

TEST(WeatherEffect, ABeamHasEightParticlesAtMost) {
  const World world = sky(100);
  std::vector<int> perBeam(world.hits.size());
  const Returns returns = run(world, {"weather: {kind: fog, visibility_m: 10, least: 0.00001}"});
  for (const std::uint32_t row : particles(returns)) ++perBeam[returns.beam(row)];
  EXPECT_EQ(*std::max_element(perBeam.begin(), perBeam.end()), 8);
  EXPECT_EQ(makeEffect("weather: {kind: fog}")->mostReturns(1), 9u);
}

TEST(WeatherEffect, SeveritiesAreALadder) {
  for (const std::string kind : {"rain", "snow", "fog", "dust"}) {
    double last = 2;
    for (const std::string severity : {"light", "moderate", "heavy"}) {
      const World world = wallAt(30);
      const Returns returns = run(world, {"weather: {kind: " + kind + ", severity: " + severity + ", wet: 0}"});
      EXPECT_LT(returns.gain[0], last) << kind << " " << severity;
      last = double{returns.gain[0]};
    }
    EXPECT_LT(last, 0.95) << kind;
  }
}

// A sensor whose file gives no width of the beam or no pulse has the usual ones, and this is reported.
TEST(WeatherEffect, SensorsWithoutABeamOrAPulseHaveTheUsualOnes) {
  const World full = sky();
  World bare = sky();
  bare.beams().divergence = {};
  bare.beams().pulse = 0;
  for (const char* weather : {"weather: {kind: rain, severity: heavy}", "weather: {kind: fog, visibility_m: 60}"}) {
    const Returns expected = run(full, {weather});
    const Returns returns = run(bare, {weather});
    EXPECT_GT(particles(returns).size(), 100u);
    EXPECT_EQ(returns.range, expected.range) << weather;
    EXPECT_EQ(makeEffect(weather)->assumed(*bare.shot.beams), "`divergence_mrad: 3` and `pulse_ns: 5`");
    EXPECT_EQ(makeEffect(weather)->assumed(*full.shot.beams), "");
  }
}

// The share of the beams into the sky that report fog, and the ranges (m) of these returns.
struct Fog {
  double share = 0;
  std::vector<double> ranges;
};

// `file`: a preset that has effects. Footprints are left out.
Fog fogOfPreset(const Value& file, double visibility) {
  World world;
  world.shot.seed = 7;
  world.shot.beams = makeBeams(file);
  world.shot.worldFromSensor.resize(1);
  world.materials.resize(1);
  world.hits.reset(world.beams().rings, world.beams().columns, Channels::all());
  for (std::size_t beam = 0; beam < world.hits.size(); ++beam) miss(world, beam);
  Value list = parseYaml(fmt::format("[weather: {{kind: fog, visibility_m: {}}}]", visibility), "test.yaml");
  for (const Value& item : file.find("effects")->items) {
    if (item.entries.front().key != "footprint") list.items.push_back(item);
  }
  Effects effects = effectsOf(list);
  std::stable_sort(effects.begin(), effects.end(),
                   [](const ChosenEffect& a, const ChosenEffect& b) { return a.entry->stage < b.entry->stage; });
  const Returns returns = runEffects(world, effects);
  Fog result;
  for (const std::uint32_t row : particles(returns)) result.ranges.push_back(double{returns.range[row]});
  result.share = static_cast<double>(result.ranges.size()) / static_cast<double>(world.hits.size());
  std::sort(result.ranges.begin(), result.ranges.end());
  return result;
}

// No sensor's receiver is as strong at a metre as far away, so haze is not reported.
TEST(WeatherEffect, PresetsDoNotReportHaze) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SCANMILL_SOURCE_DIR "/pipelines/sensors")) {
    const Value file = readYaml(entry.path());
    if (file.find("effects") == nullptr) continue;
    EXPECT_LT(fogOfPreset(file, 1000).share, 0.001) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 15);
}

// Sensors that find a target of 10 % at 35 to 75 m report fog that drivers call dense. Hahner et al. take the returns
// between 1.75 and 10 m, above the ground, as the fog in scans of an HDL-64E in dense fog (extract_fog.py of their
// program LiDAR_fog_sim, for the dataset Seeing Through Fog).
TEST(WeatherEffect, PresetsReportDenseFogWithinTenMetres) {
  for (const char* name : {"hdl_64e", "vlp_16", "os1_64"}) {
    const Value file = readYaml(std::string(SCANMILL_SOURCE_DIR "/pipelines/sensors/") + name + ".yaml");
    EXPECT_LT(fogOfPreset(file, 500).share, 0.001) << name;
    EXPECT_LT(fogOfPreset(file, 182).share, name == std::string("hdl_64e") ? 0.5 : 0.15) << name;
    const Fog dense = fogOfPreset(file, 40);
    EXPECT_GT(dense.share, 0.6) << name;
    EXPECT_LT(dense.ranges[dense.ranges.size() * 99 / 100], 10) << name;
  }
}

}  // namespace
}  // namespace scanmill
