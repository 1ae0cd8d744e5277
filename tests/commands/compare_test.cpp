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
  EXPECT_THAT(page, AllOf(HasSubstr("What a network would notice first"), HasSubstr("By class"), Not(HasSubstr("nan")),
                          Not(HasSubstr("http://www.w3.org/1999/xhtml\" src"))));
  const nlohmann::json result = nlohmann::json::parse(readFile(at("out/compare.json")));
  EXPECT_EQ(result["grouped_by"], "class");
  EXPECT_EQ(result["real"]["name"], "plain");
  EXPECT_EQ(result["real"]["scans"], 4);

  const Outcome same = scanmill({"compare", at("plain"), at("plain"), "-o", at("same"), "--scans", "2", "-q"});
  ASSERT_EQ(same.code, 0) << same.error;
  for (const auto& feature : nlohmann::json::parse(readFile(at("same/compare.json")))["features"]) {
    EXPECT_EQ(feature["strength"], 0);
    EXPECT_EQ(feature["area"], 0.5);
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
