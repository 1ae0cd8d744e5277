// Help, lists, and wrong usage.

#include "commands/command.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Usage, HelpOfEverythingHasExamples) {
  std::vector<std::string> names;
  for (const Command& command : commands()) names.emplace_back(command.name);
  std::vector<std::vector<std::string>> all{{"--help"}};
  for (const std::string& name : names) all.push_back({name, "--help"});
  const std::vector<Outcome> outcomes = scanmillEach(all);
  for (const Outcome& o : outcomes) {
    EXPECT_EQ(o.code, 0);
    EXPECT_EQ(o.error, "");
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_THAT(outcomes[0].out, HasSubstr("scanmill " + names[i]));
    EXPECT_THAT(outcomes[i + 1].out, AllOf(HasSubstr("Usage:"), HasSubstr("Examples:\n  scanmill " + names[i])))
        << names[i];
  }
}

TEST(Usage, VersionIsShort) {
  const Outcome o = scanmill({"--version"});
  EXPECT_EQ(o.code, 0);
  EXPECT_THAT(o.out, testing::MatchesRegex("scanmill [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(Usage, ListNamesWhatThePipelineMayName) {
  const Outcome all = scanmill({"list"});
  EXPECT_EQ(all.code, 0);
  EXPECT_THAT(all.out, AllOf(HasSubstr("methods:"), HasSubstr("ray_tracing"), HasSubstr("os1_128"),
                             HasSubstr("range_noise"), HasSubstr("draco"), HasSubstr("semantic_kitti")));
  const Outcome formats = scanmill({"list", "formats"});
  EXPECT_EQ(formats.code, 0);
  EXPECT_THAT(formats.out, AllOf(HasSubstr("pcd"), testing::Not(HasSubstr("ray_tracing"))));
  EXPECT_THAT(all.out, HasSubstr(formats.out.substr(0, formats.out.find("\n\nkeys"))));
  EXPECT_THAT(scanmill({"list", "scenes"}).out, AllOf(HasSubstr("hamlet"), testing::Not(HasSubstr("empty"))))
      << "which has nothing to scan";
}

TEST(Usage, AFullStandardOutputIsAFailure) {
  const Outcome full = RunningProgram({"sh", "-c", testedProgram() + " list > /dev/full"}).wait();
  EXPECT_EQ(full.code, 1);
  EXPECT_THAT(full.error, HasSubstr("No space left on device"));
  // A reader that has seen enough is none.
  const Outcome closed =
      RunningProgram({"sh", "-c", "{ " + testedProgram() + " list; echo code $? >&2; } | true"}).wait();
  EXPECT_EQ(closed.error, "code 0\n");
}

class Overrides : public SmallWorld {};

// As they are printed, one after the other, but with few frames and beams, and into another folder.
TEST_F(Overrides, ExamplesOfGenerateWork) {
  const std::string help = scanmill({"generate", "--help"}).out;
  const std::string prefix = "  scanmill generate ";
  std::size_t examples = 0;
  for (std::size_t at = help.find(prefix); at != std::string::npos; at = help.find(prefix, at + 1)) {
    if (help.compare(at + prefix.size(), 1, "[") == 0) continue;  // the usage
    std::string line = help.substr(at + prefix.size(), help.find('\n', at) - at - prefix.size());
    for (std::size_t out = line.find("out/"); out != std::string::npos; out = line.find("out/", out + 1)) {
      line.replace(out, 3, "\"$OUT\"");
    }
    const std::string command = "cd '" SCANMILL_SOURCE_DIR "' && " + testedProgram() + " generate " + line +
                                " -q --set trajectories.0.frames=1 --set sensors.0.columns=32";
    constexpr double kPatience = 300;  // s, for datasets of six towns beside other tests
    const Outcome o = RunningProgram({"sh", "-c", command}, {"OUT=" + this->at("examples")}).wait(kPatience);
    EXPECT_EQ(o.code, 0) << line << "\n" << o.error;
    EXPECT_THAT(o.out, HasSubstr("samples in")) << line;
    ++examples;
  }
  EXPECT_GE(examples, 4u);
  EXPECT_EQ(filesEndingIn("manifest.json", this->at("examples")).size(), examples);
}

// Values hold commas, as in the example of the help.
TEST_F(Overrides, ListsAreOneValue) {
  const Outcome o = scanmill({"plan", pipeline_, "--set", "scenes.0.seeds=[4,5]", "--set",
                              "splits={by: seed, train: [4], val: [5]}", "--seed", "7"});
  EXPECT_EQ(o.code, 0) << o.error;
  EXPECT_THAT(o.out, AllOf(HasSubstr("scene-s4-drive"), HasSubstr("scene-s5-drive"), HasSubstr("val")));
}

}  // namespace
}  // namespace scanmill
