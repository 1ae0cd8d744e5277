// The trade-off study as a user runs it.

#include <fmt/core.h>

#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class Tradeoff : public SmallWorld {
 protected:
  Tradeoff() {
    study_ =
        folder_
            .write("study.yaml", readFile(pipeline_) +
                                     "tradeoff: {settings: [ray_tracing, {particle: {refine: none, voxel_m: 0.5}}], "
                                     "encodings: [pcd, {draco: {max_error_mm: [1, 20]}}], shots: "
                                     "2, repeats: 1}\n")
            .string();
  }

  nlohmann::json studyIn(const std::string& folder) const {
    return nlohmann::json::parse(readFile(at(folder + "/tradeoff.json")));
  }

  static std::map<std::string, std::string> filesIn(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
      files[entry.path().filename().string()] = readFile(entry.path());
    }
    return files;
  }

  std::string study_;  // the small pipeline with a study's key
};

TEST_F(Tradeoff, WritesTablesChartsAndAReport) {
  const Outcome made = scanmill({"tradeoff", study_, "-o", at("out")});
  ASSERT_EQ(made.code, 0) << made.error;
  EXPECT_THAT(made.out, AllOf(HasSubstr("scene-s1-drive: 2 scans of 512 beams"), HasSubstr("beams/s"),
                              HasSubstr("particle refine=none voxel_m=0.5"), HasSubstr("2 settings in "),
                              HasSubstr("open " + at("out/index.html"))));
  EXPECT_THAT(made.out, AllOf(Not(HasSubstr("nan")), Not(HasSubstr("inf ")), Not(ContainsRegex(":\\s*\n\n")),
                              Not(ContainsRegex(": \n"))));
  EXPECT_THAT(made.error, HasSubstr("tradeoff 2/2 settings"));
  const auto files = filesIn(at("out"));
  for (const char* name : {"index.html", "tradeoff.json", "pareto.svg", "errors_by_range.svg",
                           "errors_by_incidence.svg", "encodings.svg", "errors-1.png"}) {
    ASSERT_THAT(files, Contains(testing::Key(name)));
    EXPECT_GT(files.at(name).size(), 500u) << name;
  }
  EXPECT_EQ(files.size(), 7u);
  EXPECT_THAT(files.at("index.html"), AllOf(HasSubstr("</html>"), HasSubstr("<svg"), HasSubstr("voxel_m=0.5")));
  EXPECT_THAT(files.at("pareto.svg"), AllOf(HasSubstr("<svg"), HasSubstr("</svg>")));
  EXPECT_EQ(studyIn("out").at("settings").size(), 2u);
}

TEST_F(Tradeoff, AReportIsReplacedOnlyWhenAsked) {
  const std::vector<std::string> once{"tradeoff", study_, "-q", "-o", at("out")};
  const Outcome made = scanmill(once);
  ASSERT_EQ(made.code, 0) << made.error;
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(std::count(made.out.begin(), made.out.end(), '\n'), 1) << made.out;
  folder_.write("out/notes.txt", "mine");
  const auto before = filesIn(at("out"));
  expectRefused(scanmill(once), "--overwrite");
  EXPECT_EQ(filesIn(at("out")), before);
  std::vector<std::string> again = once;
  again.emplace_back("--overwrite");
  EXPECT_EQ(scanmill(again).code, 0);
  EXPECT_EQ(filesIn(at("out")).size(), before.size());
  EXPECT_EQ(readFile(at("out/notes.txt")), "mine");
}

// An earlier report stays whole where its successor was interrupted.
TEST_F(Tradeoff, AnInterruptLeavesNoReportBehind) {
  ASSERT_EQ(scanmill({"tradeoff", study_, "-q", "-o", at("out")}).code, 0);
  const auto before = filesIn(at("out"));
  for (const std::string folder : {"out", "fresh"}) {
    RunningProgram process({testedProgram(), "tradeoff", study_, "-o", at(folder), "--overwrite", "--set",
                            "tradeoff.repeats=100", "--set", "tradeoff.shots=1000", "--set", "sensors.0.columns=1024",
                            "--set", "trajectories.0.frames=1000", "--set", "trajectories.0.every_s=0.001"});
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ASSERT_TRUE(process.running());
    process.send(SIGINT);
    const Outcome o = process.wait();
    EXPECT_EQ(o.code, 128 + SIGINT) << o.signal << o.error;
    EXPECT_FALSE(o.late);
  }
  EXPECT_EQ(filesIn(at("out")), before);
  EXPECT_TRUE(filesIn(at("fresh")).empty());
}

}  // namespace
}  // namespace scanmill
