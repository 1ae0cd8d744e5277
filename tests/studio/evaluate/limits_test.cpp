#include "evaluate/limits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"
#include "config/fields.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

ErrorLimits limitsOf(const std::string& yaml) {
  const Value value = parseYaml(yaml, "auto.yaml");
  return readErrorLimits(value.find("max_error"), value.find("min_rate"));
}

TEST(ErrorLimits, LengthsTakeTheirUnits) {
  EXPECT_DOUBLE_EQ(*limitsOf("max_error: {p99: 2cm}").p99, 0.02);
  EXPECT_DOUBLE_EQ(*limitsOf("max_error: {p99: 3 mm}").p99, 0.003);
  EXPECT_DOUBLE_EQ(*limitsOf("max_error: {p99: 0.02m}").p99, 0.02);
  EXPECT_DOUBLE_EQ(*limitsOf("max_error: {p99: 1.5e-1 m}").p99, 0.15);
  EXPECT_DOUBLE_EQ(*limitsOf("max_error: {p99: '2 cm'}").p99, 0.02);
  EXPECT_EQ(*limitsOf("max_error: {max: 0 mm}").max, 0);
}

TEST(ErrorLimits, SharesAreNumbersOrPerCent) {
  EXPECT_DOUBLE_EQ(*limitsOf("max_error: {miss_rate: 0.1%}").missRate, 0.001);
  EXPECT_DOUBLE_EQ(*limitsOf("max_error: {miss_rate: 0.1 %}").missRate, 0.001);
  EXPECT_DOUBLE_EQ(*limitsOf("max_error: {labels: 0.999}").labels, 0.999);
  EXPECT_EQ(*limitsOf("max_error: {labels: 100%}").labels, 1);
  EXPECT_EQ(*limitsOf("max_error: {miss_rate: 0}").missRate, 0);
}

TEST(ErrorLimits, EveryKeyIsRead) {
  const ErrorLimits l = limitsOf(
      "max_error: {mean: 1 mm, rms: 2 mm, median: 3 mm, p95: 4 mm, p99: 5 mm, p999: 6 mm, max: 7 mm, intensity: 8,\n"
      "            miss_rate: 9 %, labels: 91 %, classes: 92 %, instances: 93 %}\n"
      "min_rate: 5e6\n");
  const std::vector<std::optional<double>> read{l.mean,    l.rms,       l.median,    l.p95,      l.p99,
                                                l.p999,    l.max,       l.intensity, l.missRate, l.labels,
                                                l.classes, l.instances, l.minRate};
  const std::vector<double> expected{0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007, 8, 0.09, 0.91, 0.92, 0.93, 5e6};
  for (std::size_t i = 0; i < read.size(); ++i) {
    ASSERT_TRUE(read[i]) << i;
    EXPECT_DOUBLE_EQ(*read[i], expected[i]) << i;
  }
  EXPECT_FALSE(limitsOf("min_rate: 1e6").p99);
  EXPECT_FALSE(limitsOf("max_error: {p99: 1 cm}").minRate);
}

TEST(ErrorLimits, WrongTextsNameTheirPlaceAndKey) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> wrong{
      {"p99: 2", {"auto.yaml:3", "p99", "unit", "2 mm", "'2'"}},
      {"p99: -2 cm", {"auto.yaml:3", "p99", "at least 0", "'-2 cm'"}},
      {"p99: 2 inches", {"auto.yaml:3", "p99", "mm, cm or m"}},
      {"p99: cm", {"auto.yaml:3", "p99"}},
      {"p99: inf m", {"auto.yaml:3", "p99"}},
      {"p99: nan cm", {"auto.yaml:3", "p99"}},
      {"p99: 2 %", {"auto.yaml:3", "p99", "mm, cm or m"}},
      {"p99: [2 cm]", {"auto.yaml:3", "p99", "a list"}},
      {"p99: {most: 2 cm}", {"auto.yaml:3", "p99", "a map"}},
      {"p98: 2 cm", {"auto.yaml:3", "p98", "did you mean"}},
      {"missrate: 1 %", {"auto.yaml:3", "missrate", "miss_rate"}},
      {"min_rate: 1e6", {"auto.yaml:3", "min_rate"}},
      {"labels: 99.5", {"auto.yaml:3", "labels", "99.5 %"}},
      {"labels: 101 %", {"auto.yaml:3", "labels", "100 %"}},
      {"labels: -1 %", {"auto.yaml:3", "labels"}},
      {"miss_rate: 2 cm", {"auto.yaml:3", "miss_rate", "%"}},
      {"miss_rate: few", {"auto.yaml:3", "miss_rate", "'few'"}},
      {"intensity: -1", {"auto.yaml:3", "intensity", "at least 0"}},
      {"intensity: 3 %", {"auto.yaml:3", "intensity"}},
  };
  for (const auto& [line, words] : wrong) {
    SCOPED_TRACE(line);
    expectInputError([&] { limitsOf("name: x\nmax_error:\n  " + line + "\n"); }, words);
  }
  for (const char* rate : {"0", "-1e6", "fast", "5 cm", "[1]", "inf"}) {
    SCOPED_TRACE(rate);
    expectInputError([&] { limitsOf(std::string("name: x\nmin_rate: ") + rate + "\n"); }, {"auto.yaml:2", "min_rate"});
  }
  expectInputError([&] { limitsOf("name: x\nmax_error: 2 cm\n"); }, {"auto.yaml:2", "max_error", "a map"});
}

TEST(ErrorLimits, AskingForNothingIsRefused) {
  expectInputError([&] { limitsOf("name: x\nmax_error: {}\n"); }, {"auto.yaml:2", "max_error", "min_rate"});
  expectInputError([&] { limitsOf("name: x\nmax_error: {p99: }\nmin_rate:\n"); }, {"auto.yaml:2", "p99: 2 cm"});
  expectInputError([&] { limitsOf("name: x\nmin_rate:\n"); }, {"min_rate"});
  expectInputError([&] { readErrorLimits(nullptr, nullptr); }, {"max_error", "min_rate"});
  EXPECT_TRUE(limitsOf("max_error: {}\nmin_rate: 1e6").minRate);
}

Candidate candidateOf(double secondsPerBeam, double p99, double missRate = 0, double labels = 1) {
  Candidate c;
  c.secondsPerBeam = secondsPerBeam;
  c.errors.beams = 2'000'000;
  c.errors.falseNegatives = static_cast<std::uint64_t>(std::llround(missRate * 2e6));
  c.errors.bothHit = 1'000'000;
  c.errors.sameLabel = static_cast<std::uint64_t>(std::llround(labels * 1e6));
  c.errors.sameClass = c.errors.sameInstance = c.errors.sameLabel;
  c.errors.range.count = 1'000'000;
  c.errors.range.p99 = p99;
  return c;
}

TEST(Broken, SaysWhatDoesNotHoldWithFigures) {
  const ErrorLimits l = limitsOf("max_error: {p99: 2 cm, miss_rate: 0.1 %, labels: 99.5 %}\nmin_rate: 5e6");
  EXPECT_TRUE(broken(candidateOf(2e-7, 0.02, 0.001, 0.995), l).empty());
  EXPECT_EQ(broken(candidateOf(1e-7, 0.031), l), std::vector<std::string>{"p99 31 mm, but at most 20 mm are allowed"});
  EXPECT_EQ(broken(candidateOf(1e-7, 0.01, 0.0031, 0.99), l),
            (std::vector<std::string>{"miss_rate 0.31 %, but at most 0.1 % are allowed",
                                      "labels 99 %, but at least 99.5 % are required"}));
  EXPECT_EQ(broken(candidateOf(1e-6, 0.01), l),
            std::vector<std::string>{"min_rate 1 million beams/s, but at least 5 million beams/s are required"});
}

// Three digits would say that 20 mm are more than 20 mm.
TEST(Broken, FiguresShowThatTheLimitIsExceeded) {
  EXPECT_EQ(broken(candidateOf(1, 0.020004), limitsOf("max_error: {p99: 2 cm}")),
            std::vector<std::string>{"p99 20.004 mm, but at most 20 mm are allowed"});
  EXPECT_EQ(broken(candidateOf(1, 0, 0, 0.99999), limitsOf("max_error: {labels: 100 %}")),
            std::vector<std::string>{"labels 99.999 %, but at least 100 % are required"});
}

TEST(Broken, WithoutCommonHitsTheMissRateDecides) {
  Candidate blind;
  blind.secondsPerBeam = 1;
  blind.errors.beams = 100;
  blind.errors.falseNegatives = 100;
  EXPECT_TRUE(broken(blind, limitsOf("max_error: {max: 0 mm, intensity: 0, labels: 100 %}")).empty());
  EXPECT_EQ(broken(blind, limitsOf("max_error: {max: 0 mm, miss_rate: 1 %}")),
            std::vector<std::string>{"miss_rate 100 %, but at most 1 % are allowed"});
}

TEST(Broken, WhatIsNotKnownDoesNotHold) {
  const double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(broken(candidateOf(1, 0), limitsOf("max_error: {intensity: 1}")),
            std::vector<std::string>{"intensity is unknown, but at most 1 are allowed"});
  EXPECT_EQ(broken(candidateOf(1, kNaN), limitsOf("max_error: {p99: 1 m}")),
            std::vector<std::string>{"p99 is unknown, but at most 1 m are allowed"});
  EXPECT_EQ(broken(candidateOf(kNaN, 0), limitsOf("min_rate: 1")).size(), 1u);
  const std::vector<Candidate> unknown{candidateOf(kNaN, 0), candidateOf(3, 0.5)};
  EXPECT_EQ(cheapest(unknown, limitsOf("max_error: {p99: 1 m}")), 1u);
}

std::vector<Candidate> randomCandidates(std::uint32_t stream, std::size_t count) {
  std::vector<Candidate> candidates;
  for (std::uint32_t i = 0; i < count; ++i) {
    const RandomBlock r = randomBlock({9, stream, 0, 0, i, 0, Purpose::Test});
    // Few values, so that there are equals.
    candidates.push_back(
        candidateOf(1e-7 * (1 + r[0] % 8), 0.005 * (r[1] % 8), 0.001 * (r[2] % 8), 1 - 0.001 * (r[3] % 8)));
  }
  return candidates;
}

TEST(Cheapest, IsWhatBruteForceFinds) {
  std::size_t found = 0;
  for (std::uint32_t stream = 0; stream < 200; ++stream) {
    const std::vector<Candidate> candidates = randomCandidates(stream, 30);
    const RandomBlock r = randomBlock({10, stream, 0, 0, 0, 0, Purpose::Test});
    ErrorLimits l{.p99 = 0.04 * uniform(r[0]), .missRate = 0.008 * uniform(r[1])};
    if (r[2] % 2 == 0) l.labels = 1 - 0.008 * uniform(r[2]);
    if (r[3] % 2 == 0) l.minRate = 1e6 + 4e6 * uniform(r[3]);
    std::optional<std::size_t> expected;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Candidate& c = candidates[i];
      const bool good = c.errors.range.p99 <= *l.p99 && c.errors.missRate() <= *l.missRate &&
                        (!l.labels || c.errors.labels() >= *l.labels) &&
                        (!l.minRate || 1 / c.secondsPerBeam >= *l.minRate);
      if (good && (!expected || c.secondsPerBeam < candidates[*expected].secondsPerBeam)) expected = i;
    }
    EXPECT_EQ(cheapest(candidates, l), expected) << stream;
    found += expected ? 1 : 0;
    const std::size_t nearest = nearestToHolding(candidates, l);
    EXPECT_EQ(broken(candidates[nearest], l).empty(), expected.has_value());
    if (expected) {
      EXPECT_EQ(nearest, *expected) << stream;
    }
  }
  EXPECT_GT(found, 20u);
  EXPECT_LT(found, 190u);
  EXPECT_FALSE(cheapest({}, {}));
}

// Which factor is the largest is worked out by hand.
TEST(BestThatHolds, WithinTheNoiseOfTimeIsTheMostExact) {
  // Cost, p99, miss rate, labels.
  const std::vector<Candidate> candidates{candidateOf(1.00e-7, 0.015, 0, 0.99), candidateOf(1.08e-7, 0.001, 0, 1),
                                          candidateOf(1.20e-7, 0, 0, 1)};
  EXPECT_EQ(bestThatHolds(candidates, limitsOf("max_error: {p99: 2 cm}")), 1u);
  EXPECT_EQ(bestThatHolds(candidates, limitsOf("max_error: {p99: 2 cm}\nmin_rate: 1e6")), 1u);
  EXPECT_EQ(bestThatHolds(candidates, limitsOf("max_error: {p99: 0.5 mm}")), 2u);
}

TEST(BestThatHolds, OfARateAloneIsTheMostExactThatIsFastEnough) {
  const std::vector<Candidate> candidates{candidateOf(1e-8, 0.5, 0, 0.9), candidateOf(1e-7, 0.001, 0, 1),
                                          candidateOf(1e-6, 0, 0, 1)};
  EXPECT_EQ(bestThatHolds(candidates, limitsOf("min_rate: 5e6")), 1u);
  EXPECT_EQ(bestThatHolds(candidates, limitsOf("min_rate: 5e5")), 2u);
  EXPECT_EQ(bestThatHolds(candidates, limitsOf("min_rate: 5e7")), 0u);
  EXPECT_EQ(bestThatHolds(candidates, limitsOf("min_rate: 5e8")), std::nullopt);
}

TEST(LimitTexts, SayWhatWasAskedAndWhatItCameTo) {
  EXPECT_EQ(limitTexts(candidateOf(1e-7, 0.0012, 0, 0.999989), limitsOf("max_error: {p99: 2 cm, labels: 99.5 %}")),
            (std::vector<std::string>{"p99 1.2 mm, at most 20 mm", "labels 99.9989 %, at least 99.5 %"}));
}

TEST(NearestToHolding, HasTheLeastOfTheLargestFactors) {
  const ErrorLimits l = limitsOf("max_error: {p99: 2 cm, miss_rate: 1 %, labels: 99 %}\nmin_rate: 1e6");
  const std::vector<Candidate> candidates{
      candidateOf(1e-6, 0.06),               // 3 times the p99
      candidateOf(1e-6, 0, 0.025),           // 2.5 times the misses
      candidateOf(1e-6, 0.02, 0.01, 0.978),  // 2.2 times the wrong labels
      candidateOf(2.4e-6, 0),                // 2.4 times the time
      candidateOf(1e-6, 0.042, 0.024),       // 2.1 and 2.4
  };
  EXPECT_EQ(nearestToHolding(candidates, l), 2u);
  const std::vector<Candidate> mislabelled{candidateOf(1e-6, 0, 0, 0.95), candidateOf(1e-6, 0.06)};  // 5 and 3 times
  EXPECT_EQ(nearestToHolding(mislabelled, l), 1u);
  EXPECT_THROW(nearestToHolding({}, l), Error);
  const ErrorLimits exact = limitsOf("max_error: {p99: 0 mm}");
  EXPECT_EQ(nearestToHolding(candidates, exact), 1u);
  const std::vector<Candidate> none{candidateOf(1, 0.3), candidateOf(1, 0.1), candidateOf(0.5, 0.1)};
  EXPECT_EQ(nearestToHolding(none, exact), 2u);  // of equals the cheaper
}

TEST(ParetoFront, IsWhatBruteForceFinds) {
  for (std::uint32_t stream = 0; stream < 50; ++stream) {
    std::vector<double> a;
    std::vector<double> b;
    for (std::uint32_t i = 0; i < 60; ++i) {
      const RandomBlock r = randomBlock({11, stream, 0, 0, i, 0, Purpose::Test});
      // Half of the runs on a coarse grid, where many are equal.
      a.push_back(stream % 2 == 0 ? uniform(r[0]) : r[0] % 6);
      b.push_back(stream % 2 == 0 ? uniform(r[1]) : r[1] % 6);
      if (r[2] % 20 == 0) a.back() = std::numeric_limits<double>::quiet_NaN();
      if (r[3] % 20 == 0) b.back() = std::numeric_limits<double>::infinity();
    }
    std::vector<std::size_t> expected;
    for (std::size_t i = 0; i < a.size(); ++i) {
      bool beaten = std::isnan(a[i]) || std::isnan(b[i]);
      for (std::size_t j = 0; j < a.size(); ++j) {
        beaten = beaten || (a[j] <= a[i] && b[j] <= b[i] && (a[j] < a[i] || b[j] < b[i]));
      }
      if (!beaten) expected.push_back(i);
    }
    const std::vector<std::size_t> front = paretoFront(a, b);
    EXPECT_TRUE(std::ranges::is_sorted(front, [&](std::size_t l, std::size_t r) { return a[l] < a[r]; }));
    std::vector<std::size_t> members = front;
    std::ranges::sort(members);
    EXPECT_EQ(members, expected) << stream;
  }
}

TEST(ParetoFront, OfFewAndOfNone) {
  EXPECT_TRUE(paretoFront({}, {}).empty());
  const std::vector<double> one{3};
  EXPECT_EQ(paretoFront(one, one), std::vector<std::size_t>{0});
  const std::vector<double> two{3, 4};
  EXPECT_THROW(paretoFront(one, two), Error);
}

}  // namespace
}  // namespace scanmill
