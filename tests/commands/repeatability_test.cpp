// `scanmill repeatability`: a report of repeated scans.

#include <algorithm>

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

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
  EXPECT_THAT(o.out, AllOf(HasSubstr("after ICP"), HasSubstr("scene drive"), HasSubstr("index.html")));
  for (const char* name : {"repeatability.json", "fitness.svg", "fitness_without_icp.svg", "points.svg",
                           "noise_levels.svg", "index.html"}) {
    EXPECT_TRUE(std::filesystem::exists(at("out") + "/" + name)) << name;
  }
  EXPECT_THAT(readFile(at("out/index.html")), HasSubstr("</html>"));
}

// The small world's effects move nothing: what is said of it is no measurement.
TEST_F(RepeatabilityCommand, SaysWhatWasMeasuredAndWhatSaysNothing) {
  const Outcome o = scanmill({"repeatability", pipeline_, "-o", at("out"), "--set", "repeatability={scans: 2}", "--set",
                              "trajectories.0.frames=1"});
  ASSERT_EQ(o.code, 0) << o.error;
  EXPECT_THAT(o.out, AllOf(HasSubstr("car, seen by top"), HasSubstr("8 x 64 beams); 20"), HasSubstr("object"),
                           HasSubstr("frame"), HasSubstr("1 pose, 1 noise level: open"), Not(HasSubstr("0 +- "))));
  EXPECT_THAT(o.error, HasSubstr("no effect of this noise moves points (intensity)"));
  const std::string page = readFile(at("out/index.html"));
  EXPECT_THAT(page, AllOf(HasSubstr("no effect of this noise moves points"), HasSubstr("<dt>object</dt><dd>car"),
                          HasSubstr("<dt>sensor</dt><dd>top")));
}

TEST_F(RepeatabilityCommand, QuietIsOneLineAndTheBytesAreTheSame) {
  std::vector<std::string> quiet = arguments("a");
  quiet.insert(quiet.end(), {"-q", "--threads", "1"});
  const Outcome o = scanmill(quiet);
  EXPECT_EQ(o.code, 0) << o.error;
  EXPECT_EQ(std::count(o.out.begin(), o.out.end(), '\n'), 1);
  EXPECT_EQ(o.error, "");
  ASSERT_EQ(scanmill(arguments("b")).code, 0);
  EXPECT_EQ(readFile(at("a/repeatability.json")), readFile(at("b/repeatability.json")));
  EXPECT_EQ(readFile(at("a/index.html")), readFile(at("b/index.html")));
}

TEST_F(RepeatabilityCommand, ReplacesAReportOnlyWhenAskedTo) {
  ASSERT_EQ(scanmill(arguments("out")).code, 0);
  expectRefused(scanmill(arguments("out")), "--overwrite");
  std::vector<std::string> again = arguments("out");
  again.insert(again.end(), {"--overwrite", "--seed", "9"});
  EXPECT_EQ(scanmill(again).code, 0);
  EXPECT_THAT(readFile(at("out/repeatability.json")), HasSubstr("\"seed\": 9"));
  folder_.write("theirs/notes.txt", "mine");
  again[3] = at("theirs");
  expectRefused(scanmill(again), "theirs");
  EXPECT_EQ(readFile(at("theirs/notes.txt")), "mine");
}

TEST_F(RepeatabilityCommand, MistakesAreNamed) {
  expectRefused(scanmill({"repeatability"}), "PIPELINE is missing");
  expectRefused(scanmill({"repeatability", pipeline_}), "-o DIR is missing");
  expectRefused(scanmill({"repeatability", pipeline_, "-o", at("x"), "--set", "repeatability.scan=3"}),
                "did you mean 'scans'?");
  expectRefused(scanmill({"repeatability", pipeline_, "-o", at("x"), "--set", "repeatability.object=nothing"}),
                "no thing 'nothing'");
  EXPECT_THAT(scanmill({"repeatability", "--help"}).out, HasSubstr("Examples:\n  scanmill repeatability"));
}

}  // namespace
}  // namespace scanmill
