#include <set>

#include "base/file.h"
#include "report/page/page.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

std::set<std::string> filesBelow(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    names.insert(entry.path().lexically_relative(folder).string());
  }
  return names;
}

TEST(ReportFolder, IsMadeWithAllAboveIt) {
  const TemporaryFolder folder;
  prepareReportFolder(folder.path() / "a/b/c", "result.json", false);
  EXPECT_TRUE(fs::is_directory(folder.path() / "a/b/c"));
  prepareReportFolder(folder.path() / "a/b/c", "result.json", false);
  beginReport(folder.path() / "a/b/c", "result.json");
}

TEST(ReportFolder, ForeignFilesAreRefusedAndStay) {
  const TemporaryFolder folder;
  folder.write("notes.txt", "mine");
  for (const bool overwrite : {false, true}) {
    expectInputError([&] { prepareReportFolder(folder.path(), "result.json", overwrite); },
                     {folder.path().string(), "no result.json", "name another folder"});
    EXPECT_EQ(readFile(folder.path() / "notes.txt"), "mine");
  }
  EXPECT_THAT(filesBelow(folder.path()), ElementsAre("notes.txt"));
}

TEST(ReportFolder, AnEarlierReportIsRefusedOrReplaced) {
  const TemporaryFolder folder;
  folder.write("result.json", "old");
  folder.write("index.html", "old");
  folder.write("mine/notes.txt", "mine");
  expectInputError([&] { prepareReportFolder(folder.path(), "result.json", false); },
                   {folder.path().string(), "--overwrite"});
  EXPECT_EQ(readFile(folder.path() / "result.json"), "old");
  prepareReportFolder(folder.path(), "result.json", true);
  EXPECT_EQ(readFile(folder.path() / "result.json"), "old") << "until there is something new";
  beginReport(folder.path(), "result.json");
  EXPECT_THAT(filesBelow(folder.path()), ElementsAre("index.html", "mine", "mine/notes.txt"));
}

TEST(ReportFolder, FilesAndUnusablePlacesAreRefused) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "x");
  expectInputError([&] { prepareReportFolder(file, "result.json", true); }, {file.string(), "is a file"});
  expectInputError([&] { prepareReportFolder(file / "below", "result.json", true); }, {(file / "below").string()});
  EXPECT_EQ(readFile(file), "x");
}

}  // namespace
}  // namespace scanmill
