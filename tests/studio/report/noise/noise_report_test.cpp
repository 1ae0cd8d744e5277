#include "report/noise/noise_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/studio/study/noise/noise_scans.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(NoiseReport, HoldsTheRecordingBesideItsSimulation) {
  const auto beams = wallBeams();
  const std::vector<RecordedScan> scans =
      recordedOf(wallScans(beams, {9, 9.2},
                           "[range_noise: {sigma_m: 0.012}, dropout: {probability: 0.02}, quantize: {step_m: 0.008}]"),
                 *beams);
  const std::vector<FlatPatch> patches = findFlatPatches(*beams, scans);
  const NoiseFit fit = fitNoise(*beams, scans, patches);
  const std::string effects = effectsYaml(fit, "today");
  EXPECT_THAT(noiseReport(fit, compareNoise(*beams, scans, patches, fit, effects), "a <sensor>", effects, "today"),
              AllOf(HasSubstr("a &lt;sensor&gt;"), HasSubstr("<canvas class=\"plot\""),
                    HasSubstr("Recorded and simulated"), HasSubstr("</html>"), Not(HasSubstr("nan"))));
}

}  // namespace
}  // namespace scanmill
