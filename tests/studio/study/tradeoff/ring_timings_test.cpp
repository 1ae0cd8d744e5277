#include "study/tradeoff/ring_timings.h"

#include "base/error.h"
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
  for (std::uint32_t c = 0; c < table.columns; ++c) {
    EXPECT_EQ(made->azimuth(c), table.azimuth(c));
    EXPECT_FLOAT_EQ(made->time[c], static_cast<float>(table.columnTime(c)));
  }
  EXPECT_EQ(made->maxRange, table.maxRange);
  EXPECT_EQ(made->originOffset, table.originOffset);
  EXPECT_TRUE(made->topDown);
  EXPECT_EQ(table.elevation.size(), 5u) << "the sensor itself stays as it is";
  EXPECT_THAT(messageOf<Error>([&] { withRings(table, 1); }), HasSubstr("at least two"));
}

TEST(FitRings, ExactDataGiveBackWhatTheyWereMadeOf) {
  for (const auto& [fixed, slope] : {std::pair{1e-3, 2e-5}, {0.0, 1e-4}, {0.5, 0.0}, {0.1, 1e-9}, {1e-6, 1e-3}}) {
    for (const auto& rings : {std::vector<std::uint32_t>{16, 32, 64, 128, 256, 512}, {10, 512}}) {
      RingFit fit;
      fit.largestResidual = 99;
      for (const std::uint32_t n : rings) fit.timings.push_back({n, fixed + slope * n});
      fitRings(fit);
      EXPECT_NEAR(fit.fixedSeconds, fixed, 1e-9 * (fixed + 512 * slope));
      EXPECT_NEAR(fit.secondsPerRing, slope, 1e-9 * (fixed / 512 + slope));
      EXPECT_LT(fit.largestResidual, 1e-9);
    }
  }
}

// Errors are relative: between times of 1 s and 2 s for one number of rings, the line passes nearer to the shorter.
TEST(FitRings, IsTheLeastSquaresOfRelativeErrors) {
  RingFit fit;
  fit.timings = {{16, 1}, {16, 2}, {32, 4}};
  fitRings(fit);
  EXPECT_NEAR(fit.fixedSeconds + 16 * fit.secondsPerRing, (1 + 1 / 2.0) / (1 + 1 / 4.0), 1e-12);
  EXPECT_NEAR(fit.fixedSeconds + 32 * fit.secondsPerRing, 4, 1e-12);
  EXPECT_NEAR(fit.largestResidual, 0.4, 1e-12);
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
