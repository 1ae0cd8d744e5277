#include "base/own_folder.h"

#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class OwnFolderTest : public testing::Test {
 protected:
  OwnFolderTest() {
    fs::create_directory(outside_);
    fs::create_directory(own_);
    writeFile(outside_ / "a", "precious");
    writeFile(own_ / "a", "own");
  }

  std::vector<std::string> namesIn(const fs::path& folder) {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
    return names;
  }

  TemporaryFolder folder_;
  fs::path outside_ = folder_.path() / "outside";
  fs::path own_ = folder_.path() / "own";
};

TEST_F(OwnFolderTest, NothingChangesBehindALinkToAFolder) {
  fs::create_directory(own_ / "real");
  for (const fs::path& link : {own_ / "sub", own_ / "real/sub"}) {
    fs::create_directory_symlink(outside_, link);
    const std::vector<std::function<void()>> changes{
        [&] { makeFolders(own_, link); },
        [&] { makeFolders(own_, link / "deeper"); },
        [&] { moveFile(own_, own_ / "a", link / "a"); },
        [&] { moveFile(own_, link / "a", own_ / "b"); },
        [&] { removeFile(own_, link / "a"); },
        [&] { writeFile(own_, link / "a", "other"); },
        [&] { static_cast<void>(openFolderOf(own_, link / "a", "cannot be opened")); },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
      EXPECT_THAT(messageOf<ForeignFile>(changes[i]), AllOf(HasSubstr(link.string()), HasSubstr("remove it"))) << i;
    }
    EXPECT_EQ(readFile(outside_ / "a"), "precious");
    EXPECT_EQ(readFile(own_ / "a"), "own");
    EXPECT_EQ(namesIn(outside_).size(), 1u);
  }
}

TEST_F(OwnFolderTest, AFileInPlaceOfAFolderIsRefused) {
  EXPECT_THAT(messageOf<ForeignFile>([&] { makeFolders(own_, own_ / "a/b"); }), HasSubstr((own_ / "a").string()));
  EXPECT_THAT(messageOf<ForeignFile>([&] { writeFile(own_, own_ / "a/b", "x"); }), HasSubstr((own_ / "a").string()));
}

TEST_F(OwnFolderTest, ALinkItselfIsReplacedOrRemovedAndWhatItNamesStays) {
  for (const bool hard : {false, true}) {
    const auto link = [&](const char* name) {
      if (hard) {
        fs::create_hard_link(outside_ / "a", own_ / name);
      } else {
        fs::create_symlink(outside_ / "a", own_ / name);
      }
      return own_ / name;
    };
    writeFile(own_, link("written"), "new");
    EXPECT_EQ(readFile(own_ / "written"), "new");
    EXPECT_FALSE(fs::is_symlink(own_ / "written"));
    writeFile(own_, own_ / "b", "moved");
    moveFile(own_, own_ / "b", link("moved"));
    EXPECT_EQ(readFile(own_ / "moved"), "moved");
    removeFile(own_, link("removed"));
    EXPECT_FALSE(fs::exists(fs::symlink_status(own_ / "removed")));
    EXPECT_EQ(readFile(outside_ / "a"), "precious");
    for (const char* name : {"written", "moved"}) fs::remove(own_ / name);
  }
}

TEST_F(OwnFolderTest, TheFolderItselfMayBeALink) {
  const fs::path named = folder_.path() / "named";
  fs::create_directory_symlink("own", named);
  EXPECT_TRUE(makeFolders(named, named / "x/y"));
  EXPECT_FALSE(makeFolders(named, named / "x/y"));
  EXPECT_FALSE(makeFolders(named, named));
  writeFile(named, named / "x/y/z", "z");
  moveFile(named, named / "x/y/z", named / "p/q/z");
  EXPECT_EQ(readFile(own_ / "p/q/z"), "z");
  removeFile(named, named / "p/q/z");
  removeFile(named, named / "p/nowhere/z");
  EXPECT_TRUE(fs::is_empty(own_ / "p/q"));
}

TEST_F(OwnFolderTest, WhatLiesWithinIsDecidedByNamesAndLinks) {
  const fs::path named = folder_.path() / "named";
  fs::create_directory_symlink("own", named);
  for (const fs::path& inside : {own_, own_ / "", own_ / "..hits", own_ / "x/../y", named, named / "new/one"}) {
    EXPECT_TRUE(isWithin(inside, own_)) << inside;
    EXPECT_TRUE(isWithin(inside, named)) << inside;
  }
  for (const fs::path& beside : {folder_.path(), outside_, own_ / "../outside", fs::path(own_.string() + "er")}) {
    EXPECT_FALSE(isWithin(beside, own_)) << beside;
  }
  fs::create_symlink("circle", folder_.path() / "circle");
  const fs::path lost = folder_.path() / "circle/x";
  EXPECT_THROW(isWithin(lost, own_), Error);
  EXPECT_THROW(isWithin(own_, lost), Error) << "a folder that cannot be resolved does not hold everything";
}

// Processes of one number run side by side in containers.
TEST_F(OwnFolderTest, NoTwoWritersShareATemporaryName) {
  const AtomicFile one(own_ / "train-000000.tar");
  const AtomicFile two(own_ / "train-000000.tar");
  std::vector<std::string> names = namesIn(own_);
  std::erase(names, "a");
  ASSERT_EQ(names.size(), 2u);
  EXPECT_NE(names[0], names[1]);
  for (const std::string& name : names) EXPECT_TRUE(name.starts_with("train-000000.tar.partial-")) << name;
}

}  // namespace
}  // namespace scanmill
