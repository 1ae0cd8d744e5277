#include "report/noise/noise_report.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/studio/study/noise/noise_scans.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

struct Compared {
  NoiseFit fit;
  NoiseComparison comparison;
  std::string effects;
};

Compared comparedOf(const std::vector<Scan>& recorded, const BeamTable& beams) {
  const std::vector<RecordedScan> scans = recordedOf(recorded, beams);
  const std::vector<FlatPatch> patches = findFlatPatches(beams, scans);
  Compared compared;
  compared.fit = fitNoise(beams, scans, patches);
  compared.effects = effectsYaml(compared.fit, "today");
  compared.comparison = compareNoise(beams, scans, patches, compared.fit, compared.effects);
  return compared;
}

TEST(NoiseReport, SaysHowTheSensorMoved) {
  const auto beams = wallBeams();
  const Pose there{fromYawPitchRoll(0.02, 0.004, -0.003), {0.28, -0.06, 0.02}};
  const Compared compared = comparedOf(cornerScans(beams, there), *beams);
  ASSERT_EQ(compared.comparison.fitness.size(), 1u);
  const Vec3d motion = compared.comparison.fitness.front().recordedMotion.targetFromSource.translation;
  EXPECT_THAT(noiseReport(compared.fit, compared.comparison, "s", "effects: []\n", "today"),
              AllOf(HasSubstr(fmt::format("{:.3f} ±", length(motion))), Not(HasSubstr("did not converge:"))));
}

TEST(NoiseReport, IsWholeWhereTheMotionIsNotFound) {
  const auto beams = wallBeams();
  const Compared compared =
      comparedOf(wallScans(beams, {9, 9.2},
                           "[range_noise: {sigma_m: 0.012}, dropout: {probability: 0.02}, quantize: {step_m: 0.008}]"),
                 *beams);
  EXPECT_THAT(noiseReport(compared.fit, compared.comparison, "a <sensor>", compared.effects, "today"),
              AllOf(HasSubstr("a &lt;sensor&gt;"), HasSubstr("<canvas class=\"plot\""), HasSubstr("recorded"),
                    HasSubstr("</html>"), HasSubstr("did not converge:"), Not(HasSubstr("nan"))));
}

}  // namespace
}  // namespace scanmill
