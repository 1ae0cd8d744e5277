#include "evaluate/limits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

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
  const ErrorLimits l{.p99 = 0.02, .missRate = 0.001, .labels = 0.995};
  EXPECT_TRUE(broken(candidateOf(2e-7, 0.02, 0.001, 0.995), l).empty());
  EXPECT_EQ(broken(candidateOf(1e-7, 0.031), l), std::vector<std::string>{"p99 31 mm, but at most 20 mm are allowed"});
  EXPECT_EQ(broken(candidateOf(1e-7, 0.01, 0.0031, 0.99), l),
            (std::vector<std::string>{"miss_rate 0.31 %, but at most 0.1 % are allowed",
                                      "labels 99 %, but at least 99.5 % are required"}));
}

// Three digits would say that 20 mm are more than 20 mm.
TEST(Broken, FiguresShowThatTheLimitIsExceeded) {
  EXPECT_EQ(broken(candidateOf(1, 0.020004), {.p99 = 0.02}),
            std::vector<std::string>{"p99 20.004 mm, but at most 20 mm are allowed"});
  EXPECT_EQ(broken(candidateOf(1, 0, 0, 0.99999), {.labels = 1}),
            std::vector<std::string>{"labels 99.999 %, but at least 100 % are required"});
}

TEST(Broken, WithoutCommonHitsTheMissRateDecides) {
  Candidate blind;
  blind.secondsPerBeam = 1;
  blind.errors.beams = 100;
  blind.errors.falseNegatives = 100;
  EXPECT_TRUE(broken(blind, {.p99 = 0, .labels = 1}).empty());
  EXPECT_EQ(broken(blind, {.p99 = 0, .missRate = 0.01}),
            std::vector<std::string>{"miss_rate 100 %, but at most 1 % are allowed"});
}

TEST(Broken, WhatIsNotKnownDoesNotHold) {
  const double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(broken(candidateOf(1, kNaN), {.p99 = 1}),
            std::vector<std::string>{"p99 is unknown, but at most 1 m are allowed"});
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

TEST(NearestToHolding, IsTheCheapestThatKeepsAllLimitsIfOneDoes) {
  std::size_t found = 0;
  for (std::uint32_t stream = 0; stream < 200; ++stream) {
    const std::vector<Candidate> candidates = randomCandidates(stream, 30);
    const RandomBlock r = randomBlock({10, stream, 0, 0, 0, 0, Purpose::Test});
    ErrorLimits l{.p99 = 0.04 * uniform(r[0]), .missRate = 0.008 * uniform(r[1])};
    if (r[2] % 2 == 0) l.labels = 1 - 0.008 * uniform(r[2]);
    std::optional<std::size_t> expected;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Candidate& c = candidates[i];
      const bool good = c.errors.range.p99 <= *l.p99 && c.errors.missRate() <= *l.missRate &&
                        (!l.labels || c.errors.labels() >= *l.labels);
      EXPECT_EQ(broken(c, l).empty(), good);
      if (good && (!expected || c.secondsPerBeam < candidates[*expected].secondsPerBeam)) expected = i;
    }
    const std::size_t nearest = nearestToHolding(candidates, l);
    EXPECT_EQ(broken(candidates[nearest], l).empty(), expected.has_value());
    if (expected) {
      EXPECT_EQ(nearest, *expected) << stream;
      ++found;
    }
  }
  EXPECT_GT(found, 20u);
  EXPECT_LT(found, 190u);
}

// Which factor is the largest is worked out by hand.
TEST(NearestToHolding, HasTheLeastOfTheLargestFactors) {
  const ErrorLimits l{.p99 = 0.02, .missRate = 0.01, .labels = 0.99};
  const std::vector<Candidate> candidates{
      candidateOf(1e-6, 0.06),               // 3 times the p99
      candidateOf(1e-6, 0, 0.025),           // 2.5 times the misses
      candidateOf(1e-6, 0.02, 0.01, 0.978),  // 2.2 times the wrong labels
      candidateOf(1e-6, 0.042, 0.024),       // 2.1 and 2.4
  };
  EXPECT_EQ(nearestToHolding(candidates, l), 2u);
  const std::vector<Candidate> mislabelled{candidateOf(1e-6, 0, 0, 0.95), candidateOf(1e-6, 0.06)};  // 5 and 3 times
  EXPECT_EQ(nearestToHolding(mislabelled, l), 1u);
  EXPECT_THROW(nearestToHolding({}, l), Error);
  const ErrorLimits exact{.p99 = 0};
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
