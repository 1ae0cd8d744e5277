#include "sense/effects/batches.h"

#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

constexpr std::size_t kMany = 1u << 20;

Shot shotOf(std::uint64_t seed, std::uint32_t scene = 0, std::uint32_t frame = 0, std::uint32_t sensor = 0) {
  Shot shot;
  shot.seed = seed;
  shot.scene = scene;
  shot.frame = frame;
  shot.sensor = sensor;
  return shot;
}

std::vector<double> normals(const Shot& shot, Purpose purpose, bool second = false) {
  std::vector<double> values;
  RandomWords words;
  for (std::size_t first = 0; first < kMany; first += kBatch) {
    drawWords(shot, purpose, Returns{}, first, words);
    for (std::size_t i = 0; i < kBatch; ++i) {
      const NormalPair pair = normalPair(words.a[i], words.b[i]);
      values.push_back(second ? pair.second : pair.first);
    }
  }
  return values;
}

double normalBelow(double x) {
  return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

TEST(NormalRandom, BatchesHoldTheNumbersOfTheirAddresses) {
  const Shot shot = shotOf(0x123456789ABCDEFu, 3, 7, 2);
  RandomWords words;
  for (std::size_t first : {std::size_t{0}, std::size_t{4096}, std::size_t{1} << 28}) {
    drawWords(shot, Purpose::ShellNoise, Returns{}, first, words);
    for (std::size_t i = 0; i < kBatch; ++i) {
      const RandomBlock block = randomBlock({shot.seed, shot.scene, shot.frame, shot.sensor,
                                             static_cast<std::uint32_t>(first + i), 0, Purpose::ShellNoise});
      EXPECT_EQ(words.a[i], block[0]);
      EXPECT_EQ(words.b[i], block[1]);
    }
  }
}

// Kolmogorov and Smirnov: sqrt(n) D exceeds 2.23 once in ten thousand samples.
TEST(NormalRandom, DistributionFunctionFits) {
  for (bool second : {false, true}) {
    std::vector<double> values = normals(shotOf(2), Purpose::RangeNoise, second);
    std::sort(values.begin(), values.end());
    double worst = 0;
    const double n = static_cast<double>(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double below = normalBelow(values[i]);
      worst = std::max({worst, below - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - below});
    }
    EXPECT_LT(std::sqrt(n) * worst, 2.23);
  }
}

// The radius is that of the first word alone: its tail can be counted without drawing 10 million numbers.
TEST(NormalRandom, RadiusFollowsItsQuantileToTheLastBit) {
  for (double sigma = 0.5; sigma < 6.5; sigma += 0.25) {
    const double u = std::exp(-0.5 * sigma * sigma);
    const auto bits = static_cast<std::uint32_t>(u * 4294967296.0);
    const NormalPair pair = normalPair(bits, 12345);
    EXPECT_NEAR(std::hypot(pair.first, pair.second), sigma, 1e-9 / u / sigma + 1e-12);
  }
  EXPECT_NEAR(std::hypot(normalPair(0, 7).first, normalPair(0, 7).second), std::sqrt(66 * std::log(2.0)), 1e-12);
  EXPECT_GT(std::hypot(normalPair(0xFFFFFFFFu, 7).first, normalPair(0xFFFFFFFFu, 7).second), 0);
}

TEST(NormalRandom, NeighboursFramesSensorsScenesAndPurposesAreIndependent) {
  const Shot shot = shotOf(4, 1, 1, 1);
  const std::vector<double> base = normals(shot, Purpose::RangeNoise);
  const double bound = 5 / std::sqrt(static_cast<double>(kMany));
  for (std::size_t lag : {1u, 2u, 4u, 1024u}) {
    std::vector<double> shifted(base.begin() + static_cast<std::ptrdiff_t>(lag), base.end());
    shifted.insert(shifted.end(), base.begin(), base.begin() + static_cast<std::ptrdiff_t>(lag));
    EXPECT_NEAR(correlation(base, shifted), 0, bound) << lag;
  }
  const auto independent = [&](const Shot& other, Purpose purpose) {
    EXPECT_NEAR(correlation(base, normals(other, purpose)), 0, bound);
  };
  independent(shotOf(5, 1, 1, 1), Purpose::RangeNoise);
  independent(shotOf(4, 2, 1, 1), Purpose::RangeNoise);
  independent(shotOf(4, 1, 2, 1), Purpose::RangeNoise);
  independent(shotOf(4, 1, 1, 2), Purpose::RangeNoise);
  independent(shot, Purpose::AngularJitter);
  EXPECT_NEAR(correlation(base, normals(shot, Purpose::RangeNoise, true)), 0, bound);
}

TEST(NormalRandom, BatchesWithoutReturnsAreSkipped) {
  std::vector<float> range(3 * kBatch + 5, kMiss);
  range[2 * kBatch + 1] = 4;
  std::vector<std::pair<std::size_t, std::size_t>> seen;
  forBatches(range, [&](std::size_t first, std::size_t count) { seen.emplace_back(first, count); });
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0], (std::pair<std::size_t, std::size_t>{2 * kBatch, kBatch}));
  range.back() = 1;
  seen.clear();
  forBatches(range, [&](std::size_t first, std::size_t count) { seen.emplace_back(first, count); });
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[1], (std::pair<std::size_t, std::size_t>{3 * kBatch, 5}));
}

}  // namespace
}  // namespace scanmill
