// The report of a dataset whose beams have two returns, one or none.

#include "report/dataset/dataset_report.h"
#include "tests/core/pipeline/two_returns_yard.h"

namespace scanmill {
namespace {

using ReturnsReport = TwoReturnsYard;

TEST_F(ReturnsReport, CountsEveryReturn) {
  for (const char* layout : {"dense", "organised"}) {
    SCOPED_TRACE(layout);
    make({kAllColumns, "effects=[intensity]", fmt::format("output.layout={}", layout)}, layout);
    const DatasetReport report = examineDataset(out(layout), {.samples = 2, .quiet = true});
    std::uint64_t points = 0;
    for (std::uint32_t frame = 0; frame < 4; ++frame) points += pointsOfFrame(frame);
    EXPECT_EQ(report.summary.points, points);
    EXPECT_EQ(report.summary.pointsRead, points);
    EXPECT_EQ(report.summary.scansRead, 4u);
    EXPECT_EQ(report.summary.beams, 4u * kRings * kColumns);
    std::uint64_t ofClasses = 0;
    for (const ClassSummary& c : report.summary.classes) ofClasses += c.points;
    EXPECT_EQ(ofClasses, points);
    ASSERT_EQ(report.summary.sensors.size(), 1u);
    std::uint64_t ofRanges = 0;
    for (const std::uint64_t count : report.summary.sensors[0].ranges) ofRanges += count;
    EXPECT_EQ(ofRanges, points);
    for (const DatasetWarning& warning : report.warnings) {
      EXPECT_THAT(warning.text, testing::Not(testing::HasSubstr("manifest"))) << "the scans are as it says";
    }
    ASSERT_EQ(report.pictured.size(), 2u);
    for (const PicturedScan& pictured : report.pictured) EXPECT_FALSE(pictured.pictures.empty());
    const std::string page = datasetPage(report);
    EXPECT_TRUE(page.find("points a beam") != std::string::npos);
    EXPECT_TRUE(page.find("two_returns") != std::string::npos);
  }
}

}  // namespace
}  // namespace scanmill
