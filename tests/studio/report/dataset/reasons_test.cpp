// The report of a dataset that says for every beam a reason.

#include "report/dataset/dataset_report.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using testing::Not;

using ReasonsReport = Yard;

TEST_F(ReasonsReport, HasATableAndAnImage) {
  sound({"effects=[intensity, dropout: {probability: 0.25}]", "output.reasons=true"});
  const DatasetReport report = examineDataset(out(), {.samples = 2, .quiet = true});
  EXPECT_EQ(report.reasonImages.size(), 2u);
  ASSERT_EQ(report.summary.sensors.size(), 1u);
  std::uint64_t sum = 0;
  for (const auto& [reason, beams] : report.summary.sensors[0].beamsPerReason) sum += beams;
  EXPECT_EQ(sum, report.summary.beams);
  const std::string page = datasetPage(report);
  EXPECT_THAT(page, HasSubstr("For every beam a reason"));
  EXPECT_THAT(page, HasSubstr("lost at random"));
  EXPECT_THAT(page, Not(HasSubstr("behind glass"))) << "no beam has this reason";
}

// What comes from nothing has no class, and is no mistake of the scene's rules.
TEST_F(ReasonsReport, WhatComesFromNothingIsNoWarning) {
  const std::string sensor = "sensors=[" + std::string(kTop).insert(1, "divergence_mrad: 3, pulse_ns: 5, ") + "]";
  const std::string snow = "effects=[intensity, weather: {kind: snow, severity: heavy}]";
  const DatasetReportOptions options{.samples = 0, .quiet = true};
  for (const bool told : {true, false}) {
    const std::string name = told ? "told" : "untold";
    sound({sensor, snow, fmt::format("output.reasons={}", told)}, name);
    bool warned = false;
    for (const DatasetWarning& warning : examineDataset(out(name), options).warnings) {
      warned = warned || warning.text.find("unlabelled") != std::string::npos;
    }
    EXPECT_NE(warned, told);
  }
}

TEST_F(ReasonsReport, LeavesItOutWhereTheDatasetDoesNotSay) {
  sound({"effects=[intensity]"});
  const DatasetReportOptions options{.samples = 1, .quiet = true};
  EXPECT_THAT(datasetPage(examineDataset(out(), options)), Not(HasSubstr("For every beam a reason")));
}

}  // namespace
}  // namespace scanmill
