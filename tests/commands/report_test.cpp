// `scanmill report`.

#include <sstream>

#include "base/file.h"
#include "report/dataset/dataset_report.h"
#include "tests/commands/program.h"

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

}  // namespace
}  // namespace scanmill
