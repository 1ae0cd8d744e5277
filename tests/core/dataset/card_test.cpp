#include "dataset/card.h"

#include <map>
#include <sstream>

#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The cells of the table under a heading, by rows.
std::vector<std::vector<std::string>> tableIn(const std::string& card, const std::string& heading) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(card.substr(card.find(heading)));
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  while (std::getline(lines, line) && line.starts_with("| ")) {
    rows.emplace_back();
    for (std::size_t at = 2; at < line.size();) {
      const std::size_t end = line.find(" | ", at) == std::string::npos ? line.rfind(" |") : line.find(" | ", at);
      rows.back().push_back(line.substr(at, end - at));
      at = end + 3;
    }
  }
  return rows;
}

TEST(Card, CountsAreThoseOfTheManifest) {
  const Manifest m = filledManifest();
  const std::string card = cardText(m);
  std::map<std::string, std::uint64_t> expected;
  for (const SampleRecord& sample : m.samples) {
    for (const ScanRecord& scan : sample.scans) {
      for (const auto& [id, points] : scan.pointsPerClass) expected[std::to_string(id)] += points;
    }
  }
  std::map<std::string, std::uint64_t> stated;
  for (const auto& row : tableIn(card, "| class | id |")) stated[row.at(1)] = std::stoull(row.at(2));
  EXPECT_EQ(stated, expected);
  const auto splits = tableIn(card, "| split | sequences |");
  ASSERT_EQ(splits.size(), 2u);
  EXPECT_THAT(splits[0], testing::ElementsAre("train", "1", "1"));
  EXPECT_EQ(tableIn(card, "| sensor | model |").size(), m.sensors.size());
  EXPECT_EQ(tableIn(card, "| column | unit |").size() + 3, m.columns.size());  // x, y, z
  for (const ModelledItem& item : m.modelled) EXPECT_THAT(card, HasSubstr(lineOf(item)));
  EXPECT_THAT(card, AllOf(HasSubstr(m.pipelineText), HasSubstr("License: CC-BY-4.0"), HasSubstr("Creator: Somebody")));
}

// A random mount is stated by its ends over all scans, not by that of one sequence.
TEST(Card, RandomMountsAreIntervals) {
  Manifest m = filledManifest();
  m.sensors[0].vehicleFromSensor.reset();
  for (std::size_t i = 0; i < m.samples.size(); ++i) {
    m.samples[i].scans[0].vehicleFromSensor =
        Pose{fromYawPitchRoll(radians(10), 0, 0), {1.5, 0, 1.6 + 0.25 * static_cast<double>(i)}};
  }
  const auto row = tableIn(cardText(m), "| sensor | model |").at(0);
  EXPECT_EQ(row.at(5), "1.5, 0, 1.6 to 1.85");
  EXPECT_EQ(row.at(6), "10, 0, 0");
  for (SampleRecord& sample : m.samples) sample.scans.clear();
  EXPECT_EQ(tableIn(cardText(m), "| sensor | model |").at(0).at(5), "none, none, none") << "of a sensor without a scan";
}

TEST(Card, TextOfOthersStaysText) {
  Manifest m = filledManifest();
  m.ontology.classes[1].name = "a|b";
  m.pipelineText = "name: x\n# ```\n# ````\n";
  m.about = {};
  const std::string card = cardText(m);
  EXPECT_THAT(card, AllOf(HasSubstr("| a\\|b |"), HasSubstr("\n`````yaml\n"), HasSubstr("License: not stated")));
}

}  // namespace
}  // namespace scanmill
