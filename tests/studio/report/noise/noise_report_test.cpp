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
  const FittedWalls walls;
  EXPECT_THAT(noiseReport(walls.fit, walls.comparison, "a <sensor>", walls.effects, "today"),
              AllOf(HasSubstr("a &lt;sensor&gt;"), HasSubstr("<canvas class=\"plot\""),
                    HasSubstr("Recorded and simulated"), HasSubstr("</html>"), Not(HasSubstr("nan"))));
}

}  // namespace
}  // namespace scanmill
