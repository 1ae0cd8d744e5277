#include <cstdlib>
#include <limits>

#include "viewer/coloring.h"

namespace scanmill {
namespace {

Legend scaleOf(double low, double high, double power = 1) {
  return {.title = "range (m)", .scale = true, .low = low, .high = high, .power = power};
}

// 1, 2, 5 or 10 after powers of ten are taken away, of a number or of the step that it is a multiple of.
bool isRound(double value) {
  if (value == 0) return true;
  const double decimals = std::abs(value) / std::pow(10.0, std::floor(std::log10(std::abs(value))) - 2);
  return std::abs(decimals - std::round(decimals)) < 1e-6;
}

std::vector<std::string> figuresOf(const Legend& legend) {
  std::vector<std::string> figures;
  for (const ScaleTick& tick : scaleTicks(legend)) figures.push_back(tick.figure);
  return figures;
}

// Whatever the ends: few, round, ascending, apart, and where the bar has that value.
TEST(ScaleTicks, AreRoundAndStandWhereTheirValuesAre) {
  for (const double power : {1.0, 2.0}) {
    for (double size = 1e-6; size < 1e7; size *= 3.7) {
      for (const double from : {0.0, 0.013, 0.4, -0.7, -1.0}) {
        const Legend legend = scaleOf(from * size, (from + 1) * size, power);
        const std::vector<ScaleTick> ticks = scaleTicks(legend);
        ASSERT_GE(ticks.size(), 2u) << size << " " << from;
        ASSERT_LE(ticks.size(), 6u);
        double last = -1;
        for (const ScaleTick& tick : ticks) {
          const double value = std::strtod(tick.figure.c_str(), nullptr);
          EXPECT_TRUE(isRound(value)) << tick.figure;
          EXPECT_LE(tick.figure.size(), 9u) << tick.figure;
          EXPECT_NEAR(legend.low + std::pow(tick.share, power) * size, value, 1e-6 * size);
          EXPECT_GT(tick.share, last + 0.1);
          last = tick.share;
        }
      }
    }
  }
  EXPECT_THAT(figuresOf(scaleOf(0, 100)), testing::ElementsAre("0", "20", "40", "60", "80", "100"));
  EXPECT_THAT(figuresOf(scaleOf(-1.9, 6.3)), testing::ElementsAre("0", "2", "4", "6"));
}

TEST(ScaleTicks, OfRingsAreWholeNumbers) {
  for (double high = 1; high < 200; ++high) {
    Legend legend = scaleOf(0, high);
    legend.integers = true;
    for (const std::string& figure : figuresOf(legend)) EXPECT_EQ(figure.find('.'), std::string::npos) << high;
  }
}

TEST(ScaleTicks, WhatIsNoScaleHasOneOrNone) {
  EXPECT_THAT(figuresOf(scaleOf(3, 3)), testing::ElementsAre("3"));
  EXPECT_EQ(figuresOf(scaleOf(5, 3)).size(), 1u);
  EXPECT_EQ(figuresOf(scaleOf(NAN, 3)).size(), 1u);
  EXPECT_EQ(figuresOf(scaleOf(0, INFINITY)).size(), 1u);
  EXPECT_EQ(figuresOf(scaleOf(0, 3, 0)).size(), 1u);
  EXPECT_LE(figuresOf(scaleOf(1e15, 1e15 + 0.25)).size(), 6u);
  EXPECT_LE(figuresOf(scaleOf(0, std::numeric_limits<double>::min())).size(), 6u);
}

TEST(ScaleTitle, SaysHowItRuns) {
  EXPECT_EQ(scaleTitle(scaleOf(0, 1)), "range (m)");
  EXPECT_EQ(scaleTitle(scaleOf(0, 1, 2)), "range (m), by its square root");
}

}  // namespace
}  // namespace scanmill
