#pragma once

// The yard's pipeline with a method whose beams have two returns, one or none.

#include <algorithm>
#include <string>
#include <vector>

#include "pipeline/scenes/shot_source.h"
#include "tests/core/pipeline/small_world.h"
#include "tests/support/two_returns.h"

namespace scanmill {

class TwoReturnsYard : public Yard {
 protected:
  static constexpr std::uint32_t kRings = 8;
  static constexpr std::uint32_t kColumns = 64;
  static constexpr const char* kAllColumns =
      "output.columns=[intensity, label, instance, ring, column, time, range_true, incidence, return, cause]";
  static constexpr const char* kWithoutReturn = "output.columns=[label, instance, ring, column, time, range_true]";

  static std::uint64_t pointsOfFrame(std::uint32_t frame, std::uint32_t most = 2) {
    std::uint64_t points = 0;
    for (std::uint32_t beam = 0; beam < kRings * kColumns; ++beam) points += std::min(returnsOfBeam(beam, frame), most);
    return points;
  }
  static std::uint64_t beamsThatReturn(std::uint32_t frame) { return pointsOfFrame(frame, 1); }

  // `options`: the method's map in YAML.
  Plan planned(const std::vector<std::string>& overrides, const std::string& options = "{}") const {
    return makePlan(withTwoReturns(readPipeline(pipeline_, overrides), options));
  }

  // Every dataset must be sound.
  GenerateSummary make(const std::vector<std::string>& overrides, const std::string& name = "out",
                       const std::string& options = "{}") const {
    GenerateSummary summary = generate(planned(overrides, options), {.folder = out(name), .quiet = true});
    const Verification verification = verifyDataset(out(name));
    EXPECT_THAT(verification.problems, testing::IsEmpty());
    EXPECT_EQ(verification.points, summary.points * summary.manifest.formats.size());
    return summary;
  }

  Scene scene() const {
    const Plan plan = planned({});
    return ShotSource(plan).load(0);
  }
};

}  // namespace scanmill
