#include "base/file.h"
#include "base/hash.h"
#include "base/input_budget.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

// Files that this program reads, that libraries read, and that are missing; none while another object takes them.
TEST(FilesRead, CollectsWhatTheThreadReads) {
  const TemporaryFolder folder;
  const auto read = folder.write("read.obj", "v 0 0 0");
  const auto noted = folder.write("noted.tif", "II*");
  const auto temporary = folder.write("temporary.glb", "glTF");
  const FilesRead files;
  readFile(folder.path() / "." / "read.obj");
  noteFile(noted);
  noteFile(folder.path() / "missing.png");
  {
    const FilesRead inner;
    readFile(temporary);
    EXPECT_EQ(inner.hashes().count(temporary), 1u);
  }
  const std::map<std::filesystem::path, std::string> expected{{read, xxh3("v 0 0 0")}, {noted, xxh3("II*")}};
  EXPECT_EQ(files.hashes(), expected);
}

}  // namespace
}  // namespace scanmill
