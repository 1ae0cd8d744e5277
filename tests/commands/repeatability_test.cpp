// `scanmill repeatability`: a report of repeated scans.

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class RepeatabilityCommand : public SmallWorld {
 protected:
  // Few scans, little noise: enough to write every file.
  std::vector<std::string> arguments(const std::string& folder) const {
    return withSettings({"repeatability", pipeline_, "-o", at(folder)},
                        {"repeatability={scans: 2, noise: [{name: none, effects: []}, {name: 1 cm, effects: [{shell: "
                         "{scale_m: 0.01}}]}]}"});
  }
};

TEST_F(RepeatabilityCommand, WritesAReportWithAllItsFiles) {
  const Outcome o = scanmill(arguments("out"));
  EXPECT_EQ(o.code, 0) << o.error;
  EXPECT_THAT(o.out, HasSubstr("index.html"));
  for (const char* name : {"repeatability.json", "fitness.svg", "fitness_without_icp.svg", "points.svg",
                           "noise_levels.svg", "index.html"}) {
    EXPECT_TRUE(std::filesystem::exists(at("out") + "/" + name)) << name;
  }
  EXPECT_THAT(readFile(at("out/index.html")), HasSubstr("</html>"));
}

TEST_F(RepeatabilityCommand, QuietIsOneLine) {
  std::vector<std::string> quiet = arguments("a");
  quiet.emplace_back("-q");
  const Outcome o = scanmill(quiet);
  EXPECT_EQ(o.code, 0) << o.error;
  EXPECT_EQ(std::count(o.out.begin(), o.out.end(), '\n'), 1);
  EXPECT_EQ(o.error, "");
}

}  // namespace
}  // namespace scanmill
