#include "sense/weather.h"

#include "sensors/footprint.h"
#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

World wallAt(float range) {
  return makeWideWorld(64, 1000, range);
}

World sky(std::uint32_t columns = 1000) {
  World world = makeWideWorld(64, columns, kMiss);
  for (std::size_t beam = 0; beam < world.hits.size(); ++beam) miss(world, beam);
  return world;
}

// How many drops that send back `least` or more a beam is expected to meet up to a range, by sums.
double expectedDrops(const Weather& weather, const BeamTable& beams, double least, double until) {
  double sum = 0;
  const double step = 1e-3;
  for (double r = beams.minRange + step / 2; r < until; r += step) {
    const double area = beamArea(beams, r);
    const double d2 = least * area / weather.dropEcho * r * r / 100 * std::exp(2 * weather.extinction * r);
    sum += area * weather.drops.above(std::sqrt(d2)) * step;
  }
  return sum;
}

std::vector<std::uint32_t> particles(const Returns& returns) {
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < returns.size(); ++row) {
    if (returns.returned(row) && returns.cause(row) == Cause::Weather) rows.push_back(row);
  }
  return rows;
}

TEST(WeatherEffect, DropsAreAsManyAsTheLawOfTheirSizesSays) {
  const World world = sky();
  for (const bool snow : {false, true}) {
    const Weather weather = snow ? snowOf(2) : rainOf(40);
    const Returns returns = run(world, {snow ? "weather: {kind: snow, rate_mm_h: 2, least: 0.01}"
                                             : "weather: {kind: rain, rate_mm_h: 40, "
                                               "least: 0.0005}"});
    const double mean = expectedDrops(weather, *world.shot.beams, snow ? 0.01 : 0.0005, 100);
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
      const double some = expectedDrops(weather, *world.shot.beams, snow ? 0.01 : 0.0005, until);
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

TEST(WeatherEffect, FogAnswersAsOftenAsTheExponentialLawSays) {
  const World world = sky();
  const Returns returns = run(world, {"weather: {kind: fog, visibility_m: 50, least: 0.004}", "intensity: {}"});
  const Weather fog = fogOf(50);
  const double length = pulseLength(5e-9);
  double expected = 0;
  for (int k = 0; k < 32; ++k) {
    // The mean over the stretch, whose power changes within it.
    for (int part = 0; part < 100; ++part) {
      const double r = 1 + (k + (part + 0.5) / 100) * length;
      const double mean = mistEcho(fog, length) * 100 / (r * r) * std::exp(-2 * fog.extinction * r);
      expected += std::exp(-0.004 / mean) / 100;
    }
  }
  const double n = static_cast<double>(world.hits.size());
  const std::vector<std::uint32_t> rows = particles(returns);
  EXPECT_NEAR(static_cast<double>(rows.size()) / n, expected, 0.01 * expected);
  // The power that comes back from the first stretch, from that law's tail.
  double sum = 0;
  double count = 0;
  for (const std::uint32_t row : rows) {
    if (returns.range[row] > 1 + length) continue;
    const double r = returns.range[row];
    const double mean = mistEcho(fog, length) * 100 / (r * r) * std::exp(-2 * fog.extinction * r);
    sum += (returns.power[row] - 0.004) / mean;  // the law has no memory: what is above the least follows it again
    count += 1;
  }
  EXPECT_NEAR(sum / count, 1, 0.03);
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

TEST(WeatherEffect, BeamsThatTheOwnVehicleBlocksStayEmpty) {
  World world = sky();
  world.hits.pathOfRay.assign(world.hits.size(), RayPath::Direct);
  for (std::size_t beam = 0; beam < world.hits.size(); beam += 2) world.hits.pathOfRay[beam] = RayPath::OwnVehicle;
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

TEST(WeatherEffect, RefusesWhatIsWrong) {
  EXPECT_THAT(refusal("weather: {}"), HasSubstr("kind"));
  EXPECT_THAT(refusal("weather: {kind: hail}"), HasSubstr("rain"));
  EXPECT_THAT(refusal("weather: {kind: fog, rate_mm_h: 3}"), HasSubstr("by `visibility_m`"));
  EXPECT_THAT(refusal("weather: {kind: fog, severity: heavy, visibility_m: 30}"), HasSubstr("not both"));
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

}  // namespace
}  // namespace scanmill
