// The examples: what docs/gallery.md shows is what the program copies, and its commands work.

#include <sstream>

#include "base/file.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kSource = SCANMILL_SOURCE_DIR;

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& entry : fs::directory_iterator(kSource / "pipelines/examples")) {
    const fs::path file = entry.path();
    if (file.extension() == ".yaml" && file.stem().extension().empty()) all.push_back(file.stem());
  }
  std::sort(all.begin(), all.end());
  return all;
}

class Examples : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { fs::current_path(folder_.path()); }
  void TearDown() override { fs::current_path(before_); }

  fs::path before_ = fs::current_path();
  TemporaryFolder folder_;
};

TEST_P(Examples, CommandsMakeThePicture) {
  const Outcome copied = scanmill({"example", GetParam()});
  ASSERT_EQ(copied.code, 0) << copied.error;
  std::istringstream lines(copied.out.substr(copied.out.find("\nnext:\n") + 7));
  std::string line;
  int commands = 0;
  while (std::getline(lines, line)) {
    ASSERT_TRUE(line.starts_with("  scanmill ")) << line;
    const Outcome outcome = scanmill(wordsOf(line.substr(std::string("  scanmill ").size())));
    EXPECT_EQ(outcome.code, 0) << line << "\n" << outcome.error;
    ++commands;
  }
  EXPECT_GE(commands, 1);
  const fs::path picture = GetParam() + ".png";
  ASSERT_TRUE(fs::exists(picture));
  EXPECT_TRUE(fs::exists(kSource / "docs/gallery" / picture)) << "scripts/reproduce pictures makes it";
}

TEST_P(Examples, HaveACard) {
  const Outcome copied = scanmill({"example", GetParam()});
  const std::string sentence = copied.out.substr(0, copied.out.find('\n'));
  const std::string page = readFile(kSource / "docs/gallery.md");
  EXPECT_THAT(page, HasSubstr("gallery/" + GetParam() + ".png"));
  EXPECT_THAT(page, HasSubstr("scanmill example " + GetParam() + "\n"));
  EXPECT_THAT(page, HasSubstr(sentence));
  EXPECT_THAT(scanmill({"example"}).out, HasSubstr(GetParam() + "  "));
}

INSTANTIATE_TEST_SUITE_P(Each, Examples, testing::ValuesIn(names()), [](const auto& one) { return one.param; });

TEST(Example, NothingIsOverwrittenUnasked) {
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  EXPECT_THAT(scanmill({"example", "your_meshes", "-o", out}).out, HasSubstr("next, in " + out));
  for (const char* name : {"your_meshes.yaml", "your_meshes.scene.yaml", "your_meshes.obj"}) {
    EXPECT_EQ(readFile(folder.path() / name), readFile(kSource / "pipelines/examples" / name));
  }
  writeFile(folder.path() / "your_meshes.obj", "mine");
  expectRefused(scanmill({"example", "your_meshes", "-o", out}), "exists: name another place with -o");
  EXPECT_EQ(readFile(folder.path() / "your_meshes.obj"), "mine");
  expectRefused(scanmill({"example", "your_meshes", "-o", out + "/your_meshes.obj/x"}),
                "your_meshes.obj/x: cannot be made");
  EXPECT_EQ(scanmill({"example", "your_meshes", "-o", out, "--overwrite"}).code, 0);
  EXPECT_NE(readFile(folder.path() / "your_meshes.obj"), "mine");
  expectRefused(scanmill({"example", "rain_besides_dry", "-o", out}), "did you mean 'rain_beside_dry'");
}

}  // namespace
}  // namespace scanmill
