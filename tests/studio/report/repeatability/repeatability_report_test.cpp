#include "report/repeatability/repeatability_report.h"

#include "charts/svg_text.h"
#include "tests/studio/study/repeatability/repeated_scans.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(RepeatedScans, TheReportHoldsAllChartsAndIsSelfContained) {
  const Repeatability result = measure(pipeline(std::string(kShells) + "  scans: 2\n"));
  const std::string page = repeatabilityReport(result, "2026-01-02");
  std::size_t count = 0;
  for (const std::vector<Chart>& charts :
       {repeatabilityCharts(result, 0), repeatabilityViewCharts(result, result.views[0])}) {
    for (const Chart& chart : charts) {
      EXPECT_TRUE(hasPoints(chart)) << chart.name;
      EXPECT_THAT(page, HasSubstr("aria-label=\"" + escapeXml(chart.title) + "\""));
      ++count;
    }
  }
  EXPECT_EQ(count, 5u);
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
  EXPECT_THAT(page, HasSubstr("wall ahead"));
}

TEST_F(RepeatedScans, TheReportNamesWhatWasLookedAtAndWhatIsWrong) {
  EXPECT_THAT(repeatabilityReport(measure(pipeline("  object: crate\n")), "2026-01-02"), HasSubstr("crate"));
  EXPECT_THAT(repeatabilityReport(measure(pipeline("  scans: 2\n")), "2026-01-02"),
              testing::AllOf(HasSubstr("Warning: noise"), HasSubstr("2026-01-02"), HasSubstr("21 x 21 beams")));
}

}  // namespace
}  // namespace scanmill
