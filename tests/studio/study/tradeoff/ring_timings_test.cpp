#include "study/tradeoff/ring_timings.h"

#include "base/error.h"
#include "base/random.h"
#include "sensors/sensor.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// Ring 0 the lowest or the highest; uneven, with offsets, off its axis.
BeamTable unevenTable(bool topDown) {
  BeamTable beams;
  beams.model = "uneven";
  beams.rings = 5;
  beams.columns = 32;
  beams.minRange = 0.5;
  beams.maxRange = 80;
  beams.period = 0.1;
  beams.clockwise = true;
  beams.firstAzimuth = 0.3;
  beams.elevation = {-0.4, -0.1, -0.05, 0.02, 0.2};
  if (topDown) std::ranges::reverse(beams.elevation);
  beams.azimuthOffset = {0.01, -0.01, 0.02, 0, 0.01};
  beams.firingOffset = {0, 1e-6, 2e-6, 3e-6, 4e-6};
  beams.originOffset = 0.03;
  beams.originHeight = 0.04;
  beams.topDown = topDown;
  fillBeams(beams);
  return beams;
}

TEST(WithRings, KeepsTheHighestAndTheLowestRing) {
  for (const bool topDown : {false, true}) {
    const BeamTable table = unevenTable(topDown);
    for (const std::uint32_t rings : {2u, 3u, 5u, 16u, 257u}) {
      const auto made = withRings(table, rings);
      ASSERT_EQ(made->rings, rings);
      ASSERT_EQ(made->elevation.size(), rings);
      ASSERT_EQ(made->size(), std::size_t{rings} * table.columns);
      ASSERT_EQ(made->direction.size(), made->size());
      EXPECT_DOUBLE_EQ(made->elevation.front(), table.elevation.front());
      EXPECT_DOUBLE_EQ(made->elevation.back(), table.elevation.back());
      const double step = (table.elevation.back() - table.elevation.front()) / (rings - 1);
      for (std::uint32_t r = 1; r < rings; ++r) {
        EXPECT_NEAR(made->elevation[r] - made->elevation[r - 1], step, 1e-12) << r;
      }
      for (std::size_t i = 0; i < made->size(); ++i) {
        EXPECT_NEAR(made->direction[i].z, std::sin(made->elevation[i / table.columns]), 1e-12);
      }
    }
  }
}

TEST(WithRings, ChangesNothingElse) {
  const BeamTable table = unevenTable(true);
  const auto made = withRings(table, 7);
  EXPECT_EQ(made->model, table.model);
  EXPECT_EQ(made->columns, table.columns);
  EXPECT_EQ(made->minRange, table.minRange);
  EXPECT_EQ(made->maxRange, table.maxRange);
  EXPECT_EQ(made->period, table.period);
  EXPECT_EQ(made->originOffset, table.originOffset);
  EXPECT_EQ(made->originHeight, table.originHeight);
  EXPECT_TRUE(made->clockwise);
  EXPECT_TRUE(made->topDown);
  for (std::uint32_t c = 0; c < table.columns; ++c) {
    EXPECT_EQ(made->azimuth(c), table.azimuth(c));
    EXPECT_FLOAT_EQ(made->time[c], static_cast<float>(table.columnTime(c)));
  }
  EXPECT_EQ(table.elevation.size(), 5u) << "the sensor itself stays as it is";
  EXPECT_THAT(messageOf<Error>([&] { withRings(table, 1); }), HasSubstr("at least two"));
}

RingFit exactFit(double fixed, double slope, const std::vector<std::uint32_t>& rings) {
  RingFit fit;
  for (const std::uint32_t n : rings) fit.timings.push_back({n, fixed + slope * n});
  return fit;
}

TEST(FitRings, ExactDataGiveBackWhatTheyWereMadeOf) {
  for (const auto& [fixed, slope] : {std::pair{1e-3, 2e-5}, {0.0, 1e-4}, {0.5, 0.0}, {0.1, 1e-9}, {1e-6, 1e-3}}) {
    for (const auto& rings : {std::vector<std::uint32_t>{16, 32, 64, 128, 256, 512}, {10, 512}}) {
      RingFit fit = exactFit(fixed, slope, rings);
      fit.largestResidual = 99;
      fitRings(fit);
      EXPECT_NEAR(fit.fixedSeconds, fixed, 1e-9 * (fixed + 512 * slope));
      EXPECT_NEAR(fit.secondsPerRing, slope, 1e-9 * (fixed / 512 + slope));
      EXPECT_LT(fit.largestResidual, 1e-9);
    }
  }
}

// No other line has a smaller sum of squared relative errors, and the unit of time does not matter.
TEST(FitRings, IsTheLeastSquaresOfRelativeErrors) {
  const auto sum = [](const RingFit& fit, double fixed, double slope) {
    double squares = 0;
    for (const RingTiming& t : fit.timings) squares += std::pow((fixed + slope * t.rings) / t.scanSeconds - 1, 2);
    return squares;
  };
  for (std::uint32_t i = 0; i < 200; ++i) {
    RingFit fit = exactFit(1e-3, 2e-5, {16, 64, 128, 512});
    double largest = 0;
    for (std::size_t t = 0; t < fit.timings.size(); ++t) {
      const RandomBlock r = randomBlock({.frame = static_cast<std::uint32_t>(t), .beam = i});
      fit.timings[t].scanSeconds *= 0.9 + 0.2 * uniform(r[0]);
    }
    fitRings(fit);
    const double least = sum(fit, fit.fixedSeconds, fit.secondsPerRing);
    for (const double df : {-1e-5, 0.0, 1e-5}) {
      for (const double ds : {-1e-7, 0.0, 1e-7}) {
        EXPECT_GE(sum(fit, fit.fixedSeconds + df, fit.secondsPerRing + ds), least * (1 - 1e-12));
      }
    }
    for (const RingTiming& t : fit.timings) {
      const double modelled = fit.fixedSeconds + fit.secondsPerRing * t.rings;
      largest = std::max(largest, std::abs(modelled - t.scanSeconds) / t.scanSeconds);
    }
    EXPECT_NEAR(fit.largestResidual, largest, 1e-12);
    RingFit hours = fit;
    for (RingTiming& t : hours.timings) t.scanSeconds *= 3600;
    fitRings(hours);
    EXPECT_NEAR(hours.fixedSeconds, 3600 * fit.fixedSeconds, 1e-9);
    EXPECT_NEAR(hours.largestResidual, fit.largestResidual, 1e-12);
  }
}

TEST(FitRings, RefusesWhatNoLineGoesThrough) {
  for (const std::vector<RingTiming>& timings :
       {std::vector<RingTiming>{}, {{16, 0.1}}, {{16, 0.1}, {16, 0.2}}, {{16, 0.1}, {32, 0.0}}}) {
    RingFit fit;
    fit.timings = timings;
    EXPECT_THAT(messageOf<Error>([&] { fitRings(fit); }), testing::Not("accepted"));
  }
}

}  // namespace
}  // namespace scanmill
