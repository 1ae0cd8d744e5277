#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "study/tradeoff/study.h"
#include "tests/studio/study/tradeoff/example_study.h"

namespace scanmill {
namespace {

// RFC 4180, with bare line feeds.
std::vector<std::vector<std::string>> parseCsv(const std::string& text) {
  std::vector<std::vector<std::string>> rows{{""}};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& cell = rows.back().back();
    if (quoted) {
      if (text[i] != '"') {
        cell += text[i];
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        cell += text[++i];
      } else {
        quoted = false;
      }
    } else if (text[i] == '"') {
      EXPECT_EQ(cell, "") << "a quote within a bare cell";
      quoted = true;
    } else if (text[i] == ',') {
      rows.back().emplace_back();
    } else if (text[i] == '\n') {
      rows.push_back({""});
    } else {
      cell += text[i];
    }
  }
  EXPECT_FALSE(quoted);
  EXPECT_EQ(rows.back(), std::vector<std::string>{""}) << "the last row ends";
  rows.pop_back();
  return rows;
}

// A row by the names of the columns.
std::string at(const std::vector<std::vector<std::string>>& rows, std::size_t row, const std::string& column) {
  const auto found = std::ranges::find(rows[0], column);
  EXPECT_NE(found, rows[0].end()) << column;
  return rows[row].at(static_cast<std::size_t>(found - rows[0].begin()));
}

TEST(StudyCsv, EveryRowHasTheSameCells) {
  Study study = exampleStudy();
  study.settings[2].failure = "it said \"no\",\nand more, twice";
  study.settings[2].measured = {};
  study.settings[3].setting.name = "particle cache='a, b \"c\"'";
  study.settings[4].measured.errors.all.range = {};
  study.settings[4].measured.errors.all.intensity = {};
  study.settings[4].measured.errors.all.nearestTo = {};
  study.settings[4].measured.errors.all.nearestFrom = {};
  study.settings[5].measured.errors.byRange.back().high = INFINITY;
  study.settings[6].measured.cost.stages["of two, \"three\""] = 1;
  const auto rows = parseCsv(toCsv(study));
  std::size_t expected = 1;
  for (const SettingResult& s : study.settings) {
    const BeamErrors& e = s.measured.errors;
    expected += 1 + e.byRange.size() + e.byIncidence.size() + e.byPlace.size() + e.byClass.size();
  }
  EXPECT_EQ(rows.size(), expected);
  for (std::size_t r = 0; r < rows.size(); ++r) EXPECT_EQ(rows[r].size(), rows[0].size()) << r;
  EXPECT_EQ(rows[0].back(), "failure");
  auto names = rows[0];
  std::ranges::sort(names);
  EXPECT_EQ(std::ranges::adjacent_find(names), names.end()) << "no column stands twice";
  std::size_t failures = 0;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (rows[r].back().empty()) continue;
    ++failures;
    EXPECT_THAT(at(rows, r, "method"), testing::AnyOf("particle", "depth_camera"));
    for (std::size_t c = 3; c + 1 < rows[r].size(); ++c) EXPECT_EQ(rows[r][c], "") << rows[0][c];
  }
  EXPECT_EQ(failures, 2u);
  EXPECT_THAT(toCsv(study), testing::HasSubstr("\"it said \"\"no\"\",\nand more, twice\""));
}

TEST(StudyCsv, HoldsTheFiguresOfTheStudy) {
  Study study = exampleStudy();
  study.settings[1].setting.name = "particle cache='a, b \"c\"'";
  const auto rows = parseCsv(toCsv(study));
  std::size_t row = 0;
  for (const SettingResult& s : study.settings) {
    const auto expectGroup = [&](const std::string& kind, const std::string& name, const GroupErrors& e) {
      ++row;
      ASSERT_LT(row, rows.size());
      SCOPED_TRACE(s.setting.name + " " + kind + " " + name);
      EXPECT_EQ(at(rows, row, "setting"), s.setting.name);
      EXPECT_EQ(at(rows, row, "group_kind"), kind);
      EXPECT_EQ(at(rows, row, "group"), name);
      EXPECT_EQ(at(rows, row, "beams"), std::to_string(e.beams));
      EXPECT_EQ(at(rows, row, "both_hit"), std::to_string(e.bothHit));
      EXPECT_EQ(at(rows, row, "both_miss"), std::to_string(e.bothMiss));
      EXPECT_EQ(at(rows, row, "false_negatives"), std::to_string(e.falseNegatives));
      EXPECT_EQ(at(rows, row, "false_positives"), std::to_string(e.falsePositives));
      EXPECT_EQ(at(rows, row, "unresolved"), std::to_string(e.unresolved));
      const double seconds = s.measured.cost.scanSeconds;
      const CloudErrors& cloud = s.measured.cloud;
      for (const auto& [column, value] : {std::pair("scan_s", seconds),
                                          {"beams_per_s", static_cast<double>(study.beamsPerShot) / seconds},
                                          {"class_agreed", e.classAgreed()},
                                          {"instance_agreed", e.instanceAgreed()},
                                          {"labels", e.labels()},
                                          {"range_mean_m", e.range.mean},
                                          {"range_rms_m", e.range.rms},
                                          {"range_median_m", e.range.median},
                                          {"range_p95_m", e.range.p95},
                                          {"range_p99_m", e.range.p99},
                                          {"range_p999_m", e.range.p999},
                                          {"range_max_m", e.range.max},
                                          {"intensity_mean_error", e.intensity.mean},
                                          {"group_nearest_to_mean_m", e.nearestTo.mean},
                                          {"group_nearest_from_mean_m", e.nearestFrom.mean},
                                          {"group_hausdorff_m", e.hausdorff()},
                                          {"nearest_to_mean_m", cloud.to.mean},
                                          {"nearest_from_mean_m", cloud.from.mean},
                                          {"hausdorff_m", cloud.hausdorff}}) {
        EXPECT_NEAR(std::stod(at(rows, row, column)), value, 1e-8 * std::abs(value)) << column;
      }
    };
    if (!s.failure.empty()) {
      ++row;
      EXPECT_EQ(at(rows, row, "failure"), s.failure);
      continue;
    }
    const BeamErrors& e = s.measured.errors;
    expectGroup("all", "all", e.all);
    for (const auto& [kind, groups] : {std::pair{"range_m", &e.byRange},
                                       {"incidence_deg", &e.byIncidence},
                                       {"place", &e.byPlace},
                                       {"class", &e.byClass}}) {
      for (const ErrorGroup& g : *groups) expectGroup(kind, g.name, g.errors);
    }
  }
  EXPECT_EQ(row + 1, rows.size());
}

TEST(StudyCsv, StagesStandInOneCell) {
  Study study = exampleStudy();
  study.settings.resize(2);
  study.settings[1].measured.cost.stages = {{"render", 0.0063}, {"read_back", 0.0027}};
  study.settings[1].measured.errors.all.nearestTo = {};
  study.settings[1].measured.errors.all.nearestFrom = {};
  const auto rows = parseCsv(toCsv(study));
  const auto first = std::ranges::find_if(rows, [](const auto& row) { return row[0] == "depth_camera"; });
  const auto row = static_cast<std::size_t>(first - rows.begin());
  EXPECT_EQ(at(rows, 1, "stages_s"), "") << "ray tracing keeps no account";
  EXPECT_EQ(at(rows, row, "stages_s"), "read_back=0.0027;render=0.0063");
  EXPECT_EQ(at(rows, row, "group_nearest_to_mean_m"), "") << "no distance is none, not 0";
  EXPECT_EQ(at(rows, row, "group_hausdorff_m"), "");
}

}  // namespace
}  // namespace scanmill
