#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class CompareCommand : public SmallWorld {
 protected:
  CompareCommand() {
    EXPECT_EQ(scanmill({"generate", pipeline_, "-o", at("plain"), "-q"}).code, 0);
    EXPECT_EQ(
        scanmill({"generate", pipeline_, "-o", at("noisy"), "-q", "--set", "effects=[range_noise: {sigma_m: 0.05}]"})
            .code,
        0);
  }
};

TEST_F(CompareCommand, WritesAPageAndFiguresThatNameTheDifference) {
  const Outcome made = scanmill({"compare", at("plain"), at("noisy"), "-o", at("out")});
  ASSERT_EQ(made.code, 0) << made.error;
  EXPECT_THAT(made.out,
              AllOf(HasSubstr("range scatter"), HasSubstr("effects range_noise"), HasSubstr("beams that return"),
                    HasSubstr("open " + at("out/index.html")), Not(HasSubstr("nan"))));
  std::string page = readFile(at("out/index.html"));
  page.resize(page.find("<script>"));
  EXPECT_THAT(page,
              AllOf(HasSubstr("What a network would notice first"), HasSubstr("By class"), Not(HasSubstr("nan"))));
  const nlohmann::json result = nlohmann::json::parse(readFile(at("out/compare.json")));
  EXPECT_EQ(result["grouped_by"], "class");
  EXPECT_EQ(result["real"]["name"], "plain");
  EXPECT_EQ(result["real"]["scans"], 4);
}

// Followed, the advice leaves nothing to advise.
TEST_F(CompareCommand, LeadsToTheMountOfTheFirstSet) {
  const auto make = [&](const std::string& name, const std::string& mount, const std::string& ground = "drop") {
    const std::vector<std::string> settings{"trajectories.0.ground=" + ground, "sensors.0.columns=256", mount};
    EXPECT_EQ(scanmill(withSettings({"generate", pipeline_, "-o", at(name), "-q"}, settings)).code, 0);
  };
  const auto comparedWith = [&](const std::string& name) {
    const Outcome compared = scanmill({"compare", at("tilted"), at(name), "-o", at("out"), "--overwrite", "-q"});
    EXPECT_EQ(compared.code, 0) << compared.error;
    EXPECT_EQ(compared.error.find("`ground: drop`") != std::string::npos, name == "without_wheels");
    return nlohmann::json::parse(readFile(at("out/compare.json")));
  };
  make("tilted", "sensors.0.mount={position: [0, 0, 2], pitch_deg: 2, roll_deg: 1}");
  make("upright", "sensors.0.mount={position: [0, 0, 1.8]}");
  make("without_wheels", "sensors.0.mount={position: [0, 0, 1.8]}", "{wheels: none}");
  const nlohmann::json result = comparedWith("upright");
  ASSERT_GE(result["advice"].size(), 3u) << result["unadvised"];
  EXPECT_NEAR(result["road_pose"][0]["real"]["median"].get<double>(), 2, 0.05);
  EXPECT_EQ(result["advice"][1]["key"], "sensors.0.mount.pitch_deg");
  EXPECT_NEAR(result["advice"][1]["try"].get<double>(), 2, 0.05);
  EXPECT_THAT(readFile(at("out/index.html")), HasSubstr("How the sensor stands"));
  make("advised", result["set"][0]);
  for (const auto& change : comparedWith("advised")["advice"]) {
    EXPECT_THAT(change["key"].get<std::string>(), Not(HasSubstr("mount")));
  }
  for (const auto& change : comparedWith("without_wheels")["advice"]) {
    EXPECT_THAT(change["key"].get<std::string>(), Not(HasSubstr("roll_deg")));
  }
}

TEST_F(CompareCommand, FoldersThatOthersReadAreRead) {
  for (const char* layout : {"semantic_kitti", "ply"}) {
    ASSERT_EQ(scanmill({"export", at("plain"), "--to", layout, "-o", at(layout)}).code, 0);
    const Outcome compared = scanmill({"compare", at(layout), at("noisy"), "-o", at("out"), "--overwrite", "-q"});
    ASSERT_EQ(compared.code, 0) << compared.error;
    EXPECT_THAT(scanmill({"info", at(layout)}).out, HasSubstr("4 recorded scans in the layout "));
    EXPECT_EQ(scanmill({"view", at(layout), "--screenshot", at(std::string(layout) + ".png")}).code, 0);
  }
  const std::string scan = at("semantic_kitti/sequences/00/velodyne/000000.bin");
  EXPECT_THAT(scanmill({"info", scan}).out, AllOf(HasSubstr("intensity"), HasSubstr("label")));
  EXPECT_EQ(scanmill({"view", scan, "--screenshot", at("single.png")}).code, 0);
}

}  // namespace
}  // namespace scanmill
