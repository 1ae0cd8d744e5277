// `scanmill repeatability`: figures of repeated scans.

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

TEST_F(RepeatabilityCommand, WritesFiguresThatTheScriptDraws) {
  const Outcome o = scanmill(arguments("out"));
  EXPECT_EQ(o.code, 0) << o.error;
  EXPECT_THAT(o.out, HasSubstr("repeatability.json"));
  if (RunningProgram({"/usr/bin/python3", "-c", "import matplotlib"}).wait().code != 0) {
    GTEST_SKIP() << "matplotlib is not installed";
  }
  const Outcome drawn =
      RunningProgram({"/usr/bin/python3", SCANMILL_SOURCE_DIR "/scripts/repeatability_charts", at("out")}).wait();
  EXPECT_EQ(drawn.code, 0) << drawn.error;
  for (const char* name : {"fitness.svg", "points.svg", "noise_levels.svg"}) {
    EXPECT_THAT(readFile(at("out") + "/" + name), HasSubstr("</svg>")) << name;
  }
}

}  // namespace
}  // namespace scanmill
