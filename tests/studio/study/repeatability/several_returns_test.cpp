// Repeated scans by a method whose beams have two returns, one or none.

#include "tests/studio/study/repeatability/repeated_scans.h"
#include "tests/support/two_returns.h"

namespace scanmill {
namespace {

// The crop is as large as the scan: every return is compared.
TEST_F(RepeatedScans, EveryReturnOfABeamIsCompared) {
  Pipeline read =
      withTwoReturns(readPipeline(pipeline("  scans: 3\n  object: slab\n  margin_m: 50\n  noise:\n"
                                           "    - {name: none, effects: []}\n"
                                           "    - {name: 1 cm, effects: [{range_noise: {sigma_m: 0.01}}]}\n"
                                           "    - {name: lossy, effects: [{dropout: {probability: 0.25}}]}\n"),
                                  {}),
                     "{near_m: 3, gap_m: 2}");
  const Channels channels = repeatabilityChannels(read);
  const Plan plan = makePlan(std::move(read), channels);
  RepeatabilityOptions options;
  options.quiet = true;
  const Repeatability result = measureRepeatability(plan, options);
  EXPECT_EQ(result.methods, std::vector<std::string>{"two_returns near_m=3 gap_m=2"});
  ASSERT_EQ(result.views.size(), 1u);
  ASSERT_EQ(result.views[0].places.size(), 3u);
  for (const RepeatedPlace& place : result.views[0].places) {
    std::uint64_t returns = 0;
    for (std::uint32_t beam = 0; beam < 21 * 21; ++beam) returns += returnsOfBeam(beam, place.frame);
    EXPECT_EQ(place.points[0].least, returns);
    EXPECT_EQ(place.points[1].mean, static_cast<double>(returns));
    EXPECT_NEAR(place.points[2].mean, 0.75 * static_cast<double>(returns), 0.06 * static_cast<double>(returns));
    EXPECT_EQ(result.at(place, 0, 0).unmoved.mean, 0);
    // Of two noisy ranges, each with a deviation of 1 cm. Neighbours are farther away than that.
    EXPECT_NEAR(result.at(place, 1, 1).unmoved.mean, 2e-4, 0.3e-4);
  }
}

}  // namespace
}  // namespace scanmill
