#include "base/random.h"
#include "sense/returns.h"
#include "sensors/footprint.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

constexpr double kPulse = 0.75;  // m

// One beam whose rays meet surfaces at these ranges.
struct Rays {
  Hits hits;
  std::vector<float> power;

  Rays() {
    hits.rings = hits.columns = 1;
    hits.channels = Channel::Range | Channel::Semantic;
  }

  void add(float range, float rayPower, std::uint16_t label = 1, std::uint32_t beam = 0) {
    hits.beamOfRay.push_back(beam);
    hits.weightOfRay.push_back(0.1f);
    hits.range.push_back(range);
    hits.semantic.push_back(label);
    power.push_back(rayPower);
  }

  std::vector<Echo> echoes(double pulse = kPulse) const { return findEchoes(hits, power, pulse); }
};

TEST(Echoes, TwoPlatesMergeAndSplitAtThePulseLength) {
  for (const float gap : {0.1f, 0.5f, 0.7499f, 0.7501f, 2.0f}) {
    Rays rays;
    for (int i = 0; i < 3; ++i) rays.add(10, 0.2f, 1);
    rays.add(10 + gap, 0.1f, 2);
    const std::vector<Echo> echoes = rays.echoes();
    if (gap <= kPulse) {
      ASSERT_EQ(echoes.size(), 1u) << gap;
      EXPECT_NEAR(echoes[0].range, 10 + gap / 7, 1e-5) << "between them, by power";
      EXPECT_NEAR(echoes[0].power, 0.7, 1e-6);
      EXPECT_NEAR(echoes[0].spread, gap * std::sqrt(6.0) / 7, 1e-5);
      EXPECT_EQ(rays.hits.semantic[echoes[0].hit], 1);
      EXPECT_EQ(echoes[0].label2, 2);
      EXPECT_NEAR(echoes[0].share, 6.0 / 7, 1e-6);
    } else {
      ASSERT_EQ(echoes.size(), 2u) << gap;
      EXPECT_EQ(echoes[0].range, 10);
      EXPECT_EQ(echoes[1].range, 10 + gap);
      EXPECT_NEAR(echoes[0].power, 0.6, 1e-6);
      EXPECT_NEAR(echoes[1].power, 0.1, 1e-6);
      EXPECT_EQ(rays.hits.semantic[echoes[1].hit], 2);
      EXPECT_EQ(echoes[0].label2, 0);
      EXPECT_EQ(echoes[0].share, 1);
    }
  }
}

// Beams whose rays lie within one pulse, with a far ray, appended behind all others, for every second beam: the far ray
// is an echo of its own and changes nothing in the other one.
TEST(Echoes, FarRayChangesNothingInTheNearEcho) {
  constexpr std::uint32_t kBeams = 300;
  Rays alone;
  alone.hits.columns = kBeams;
  for (std::uint32_t i = 0; i < 7 * kBeams; ++i) {
    const RandomBlock random = randomBlock({.seed = 6, .beam = i});
    const auto label = static_cast<std::uint16_t>(random[2] % 8 == 0 ? 2 : 1);
    alone.add(static_cast<float>(10 + 0.7 * uniform(random[0])), static_cast<float>(uniform(random[1])), label, i / 7);
  }
  Rays joined = alone;
  for (std::uint32_t beam = kBeams - 2; beam < kBeams; beam -= 2) joined.add(50, 0.5f, 3, beam);
  const std::vector<Echo> expected = alone.echoes();
  std::vector<Echo> echoes = joined.echoes();
  ASSERT_EQ(expected.size(), kBeams);
  ASSERT_EQ(echoes.size(), kBeams + kBeams / 2);
  std::erase_if(echoes, [](const Echo& echo) { return echo.range == 50; });
  ASSERT_EQ(echoes.size(), kBeams);
  for (std::uint32_t beam = 0; beam < kBeams; ++beam) {
    EXPECT_EQ(echoes[beam].beam, beam);
    EXPECT_EQ(echoes[beam].hit, expected[beam].hit);
    EXPECT_FLOAT_EQ(echoes[beam].range, expected[beam].range);
    EXPECT_FLOAT_EQ(echoes[beam].power, expected[beam].power);
    EXPECT_FLOAT_EQ(echoes[beam].spread, expected[beam].spread);
    EXPECT_FLOAT_EQ(echoes[beam].share, expected[beam].share);
    EXPECT_EQ(echoes[beam].label2, expected[beam].label2);
  }
}

// Rays of no order, of many beams, anywhere: no power is lost and none is made, and each beam's echoes are more than a
// pulse apart from the nearest ray of the next.
TEST(Echoes, ConserveEnergy) {
  Rays rays;
  rays.hits.columns = 200;
  std::vector<double> sent(200);
  for (std::uint32_t i = 0; i < 3800; ++i) {
    const RandomBlock random = randomBlock({.seed = 5, .beam = i});
    const std::uint32_t beam = random[0] % 200;
    const bool met = random[1] % 10 != 0;
    const float range = met ? static_cast<float>(5 + 8 * uniform(random[2])) : kMiss;
    const float power = met ? static_cast<float>(uniform(random[3])) : 0;
    rays.add(range, power, static_cast<std::uint16_t>(1 + random[1] % 4), beam);
    sent[beam] += power;
  }
  std::vector<double> received(200);
  const Echo* before = nullptr;
  const std::vector<Echo> echoes = rays.echoes();
  EXPECT_GT(echoes.size(), 400u);
  for (const Echo& e : echoes) {
    received[e.beam] += e.power;
    EXPECT_EQ(rays.hits.beamOfRay[e.hit], e.beam);
    EXPECT_GT(e.share, 0.2);
    EXPECT_LE(e.share, 1.0f);
    if (before != nullptr && before->beam == e.beam) {
      EXPECT_GT(e.range, before->range);
    }
    before = &e;
  }
  for (std::size_t beam = 0; beam < 200; ++beam) EXPECT_NEAR(received[beam], sent[beam], 1e-5 * sent[beam] + 1e-6);
}

// A plane at the angle t meets a beam of standard deviation s across at ranges that spread by r s tan t.
TEST(Echoes, OfASlantedPlaneAreAsWideAsItsSlopeSays) {
  auto beams = beamsOf({{1, 0, 0}});
  beams->divergence = {0.003, 0.003};
  for (const double degrees : {0.0, 30.0, 60.0, 75.0}) {
    for (const std::uint32_t n : {7u, 19u, 127u}) {
      const Footprint footprint = makeFootprint(*beams, n);
      const double t = radians(degrees);
      const Vec3d normal{std::cos(t), std::sin(t), 0};
      Rays rays;
      for (std::uint32_t k = 0; k < n; ++k) {
        const double range = 30 * normal.x / dot(normal, footprint.rays->direction[k]);
        rays.add(static_cast<float>(range), footprint.weight[k]);
      }
      const std::vector<Echo> echoes = rays.echoes();
      ASSERT_EQ(echoes.size(), 1u);
      EXPECT_NEAR(echoes[0].spread, 30 * 0.003 / 4 * std::tan(t), 2e-5 + 1e-3 * 30 * 0.003 / 4 * std::tan(t));
      EXPECT_NEAR(echoes[0].range, 30, 1e-3);
    }
  }
}

// What is longer than the pulse has its range at its peak, not in the middle of a long tail.
TEST(Echoes, OfLongChainsLieAtThePeak) {
  Rays rays;
  for (int i = 0; i < 12; ++i) rays.add(static_cast<float>(20 + 0.5 * i), i == 1 ? 1.0f : 0.05f);
  const std::vector<Echo> echoes = rays.echoes();
  ASSERT_EQ(echoes.size(), 1u);
  EXPECT_NEAR(echoes[0].range, 20.5, 0.05);
  EXPECT_NEAR(echoes[0].power, 1.55, 1e-5);
}

TEST(Echoes, WithoutAPulseAreTheRays) {
  Rays rays;
  for (int i = 0; i < 5; ++i) rays.add(7, 0.1f);
  EXPECT_EQ(rays.echoes(0).size(), 5u);
}

TEST(Echoes, AreAtMostSixteenTheStrongest) {
  Rays rays;
  for (int i = 0; i < 20; ++i) rays.add(static_cast<float>(5 + i), static_cast<float>(i % 5 == 0 ? 0.1 : 1));
  const std::vector<Echo> echoes = rays.echoes();
  ASSERT_EQ(echoes.size(), 16u);
  for (const Echo& e : echoes) EXPECT_EQ(e.power, 1);
}

TEST(Echoes, OfBlackSurfacesLieBetweenThem) {
  Rays rays;
  rays.add(10, 0);
  rays.add(10.2f, 0);
  const std::vector<Echo> echoes = rays.echoes();
  ASSERT_EQ(echoes.size(), 1u);
  EXPECT_NEAR(echoes[0].range, 10.1, 1e-5);
  EXPECT_EQ(echoes[0].power, 0);
  EXPECT_EQ(echoes[0].share, 1);
}

}  // namespace
}  // namespace scanmill
