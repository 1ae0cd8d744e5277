// `scanmill report`.

#include <fmt/core.h>

#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

#include "base/file.h"
#include "report/dataset/dataset_report.h"
#include "tests/commands/program.h"
#include "tests/support/mislabelled.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Pages are megabytes: nobody wants to see them printed.
bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

class ReportCommand : public SmallWorld {
 protected:
  ReportCommand() {
    EXPECT_EQ(scanmill({"generate", pipeline_, "-o", at("small"), "-q"}).code, 0);
    EXPECT_FALSE(std::filesystem::exists(at("small/report.html")));
  }
};

TEST_F(ReportCommand, WritesOnePageAndSaysWhere) {
  const Outcome o = scanmill({"report", at("small"), "-o", at("pages/a.html")});
  EXPECT_EQ(o.code, 0) << o.error;
  EXPECT_THAT(o.out, HasSubstr(at("pages/a.html")));
  EXPECT_THAT(o.error, AllOf(HasSubstr("4/4 scans"), HasSubstr("note: No points of")));
  EXPECT_EQ(filesEndingIn("", at("pages")).size(), 1u);
  const std::string page = readFile(at("pages/a.html"));
  EXPECT_TRUE(has(page, "<h1>Dataset small</h1>") && has(page, "scene-s1-drive") && has(page, "name: small"));
  // What `info` counts from the same manifest.
  const std::string info = scanmill({"info", at("small")}).out;
  for (const char* name : {"ground", "wall", "car"}) {
    std::istringstream line(info.substr(info.find(std::string("\n  ") + name + " ")));
    std::string word, id, points;
    line >> word >> id >> points;
    EXPECT_TRUE(has(page, ">" + points + "<")) << name << " " << points;
  }
}

TEST_F(ReportCommand, TheSameBytesWhateverTheThreads) {
  for (const char* threads : {"1", "4"}) {
    EXPECT_EQ(scanmill({"report", at("small"), "-q", "--threads", threads, "-o", at(threads)}).code, 0);
  }
  EXPECT_TRUE(readFile(at("1")) == readFile(at("4")));
  EXPECT_EQ(scanmill({"report", at("small"), "-q", "--seed", "9", "-o", at("other")}).code, 0);
  EXPECT_FALSE(readFile(at("1")) == readFile(at("other")));
  EXPECT_EQ(scanmill({"report", at("small"), "-q", "--samples", "0", "-o", at("none")}).code, 0);
  const std::string none = readFile(at("none"));
  EXPECT_FALSE(has(none, "<img") || has(none, "scan-data"));
}

TEST_F(ReportCommand, WithoutANameThePageLiesInTheWorkingFolder) {
  std::filesystem::create_directories(at("here"));
  for (const char* dataset : {"../small", "../small/"}) {
    const Outcome o =
        RunningProgram(
            {"sh", "-c", "cd '" + at("here") + "' && " + testedProgram() + " report -q " + dataset + " --overwrite"})
            .wait();
    EXPECT_EQ(o.code, 0) << o.error;
  }
  const auto made = filesEndingIn("", at("here"));
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made[0].filename(), "small_report.html");
  EXPECT_TRUE(filesEndingIn(".html", at("small")).empty());
}

TEST_F(ReportCommand, WrongUsageIsRefused) {
  folder_.write("there.html", "mine");
  expectRefused(scanmill({"report"}), "DATASET is missing");
  expectRefused(scanmill({"report", at("absent")}), "manifest.json does not exist");
  expectRefused(scanmill({"report", pipeline_}), "not a file");
  expectRefused(scanmill({"report", at("small"), "-o", at("there.html")}), "--overwrite");
  EXPECT_EQ(readFile(at("there.html")), "mine");
  expectRefused(scanmill({"report", at("small"), "-o", at("small")}), "is a folder");
  expectRefused(scanmill({"report", at("small"), "-o", at("there.html/a.html")}), "is a file");
  expectRefused(scanmill({"report", at("small"), "-o", ""}), "-o: the name of the file is empty");
  expectRefused(scanmill({"report", at("small"), "--samples", "65", "-o", at("x")}), "from 0 to 64");
  expectRefused(scanmill({"report", at("small"), "--samples", "-1", "-o", at("x")}), "-1");
  expectRefused(scanmill({"report", at("small"), "--seed", "one", "-o", at("x")}), "one");
  EXPECT_FALSE(std::filesystem::exists(at("x")));
  EXPECT_EQ(scanmill({"report", at("small"), "-q", "-o", at("there.html"), "--overwrite"}).code, 0);
  EXPECT_NE(readFile(at("there.html")), "mine");
}

TEST_F(ReportCommand, DamageIsAWarningUntilNothingIsLeft) {
  const auto shards = filesEndingIn(".tar", at("small"));
  ASSERT_EQ(shards.size(), 1u);
  const std::string whole = readFile(shards[0]);
  writeFile(shards[0], whole.substr(0, whole.size() / 2));
  const Outcome half = scanmill({"report", at("small"), "-o", at("half.html")});
  EXPECT_EQ(half.code, 0) << half.error;
  EXPECT_THAT(half.error, HasSubstr("missing or damaged"));
  EXPECT_TRUE(has(readFile(at("half.html")), "missing or damaged"));
  std::filesystem::remove(shards[0]);
  const Outcome none = scanmill({"report", at("small"), "-o", at("none.html")});
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.error, HasSubstr("none of its scans can be read"));
  EXPECT_FALSE(std::filesystem::exists(at("none.html")));
}

// Somebody takes a car for a building, and another for a bush, in every scan of the second street.
TEST_F(ReportCommand, FindsAThingWithTheWrongClass) {
  const std::string street = at("street");
  const Outcome made = scanmill({"generate", SCANMILL_SOURCE_DIR "/pipelines/street.yaml", "-o", street, "-q", "--set",
                                 "scenes.0.seeds=[2]", "--set", "splits=null", "--set", "trajectories.0.frames=5",
                                 "--set", "trajectories.0.every_m=24", "--set",
                                 "output.formats=[{pcd: {encoding: "
                                 "binary}}]"});
  ASSERT_EQ(made.code, 0) << made.error;
  const DatasetReport sound = examineDataset(street, {.samples = 0, .quiet = true});
  for (const DatasetWarning& w : sound.warnings) EXPECT_TRUE(w.command.empty()) << w.text;
  constexpr std::uint16_t kCar = 20, kBuilding = 6, kVegetation = 10;
  const ThingSummary* car = nullptr;
  for (const ThingSummary& t : sound.summary.things) {
    const bool van = t.size && (t.size->height > 1.6 || t.size->length > 5);
    if (t.mostClass == kCar && t.size && !van && (car == nullptr || t.points > car->points)) car = &t;
  }
  ASSERT_NE(car, nullptr);
  for (const std::uint16_t wrong : {kBuilding, kVegetation}) {
    std::string from = street;
    for (std::size_t i = 0; i < sound.manifest.samples.size(); ++i) {
      const std::string to = at(fmt::format("wrong{}-{}", wrong, i));
      copyMislabelled(from, to, sound.manifest.samples[i].key, car->id, wrong);
      from = to;
    }
    ASSERT_EQ(scanmill({"verify", from}).code, 0);
    const Outcome o = scanmill({"report", from, "--samples", "0", "-o", at("wrong.html"), "--overwrite"});
    EXPECT_EQ(o.code, 0) << o.error;
    EXPECT_THAT(o.error, HasSubstr(wrong == kBuilding
                                       ? fmt::format("warning: building {} of street-s2-lane is ", car->id)
                                       : fmt::format("warning: vegetation: instance {} of street-s2-lane", car->id)));
    const std::string command = "scanmill view " + from + " --sample " + car->bestSample + " --camera=";
    EXPECT_THAT(o.error, HasSubstr(command));
    EXPECT_TRUE(has(readFile(at("wrong.html")), command));
  }
}

// Whenever it is interrupted, there is the whole page or none.
TEST_F(ReportCommand, AnInterruptedOneLeavesNoFile) {
  for (const int milliseconds : {50, 100, 200, 400}) {
    RunningProgram program({testedProgram(), "report", at("small"), "--samples", "16", "-o", at("stopped/a.html")});
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    program.send(SIGINT);
    const Outcome o = program.wait();
    if (o.code == 0) {
      EXPECT_TRUE(readFile(at("stopped/a.html")).ends_with("</html>\n"));
      std::filesystem::remove(at("stopped/a.html"));
    } else {
      EXPECT_TRUE(o.signal == SIGINT || o.code == 128 + SIGINT) << o.code << " " << o.error;
    }
    EXPECT_TRUE(filesEndingIn("", at("stopped")).empty());
  }
}

}  // namespace
}  // namespace scanmill
