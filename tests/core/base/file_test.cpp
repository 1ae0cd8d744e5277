#include "base/file.h"

#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <fstream>

#include "base/error.h"
#include "base/memory.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t entries(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(ReadFile, RefusesMoreThanTheMemoryHolds) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("huge.json", std::string(100, ' '));
  const MemoryLimit limit(99);
  expectInputError([&] { readFile(file); }, {"huge.json: has 100 B", "only 99 B of memory"});
}

TEST(ReadFile, GivesAllBytes) {
  const TemporaryFolder folder;
  std::string bytes;
  for (int i = 0; i < 200'000; ++i) bytes += static_cast<char>(i * 7);
  EXPECT_EQ(readFile(folder.write("a.bin", bytes)), bytes);
  EXPECT_EQ(readFile(folder.write("empty", "")), "");
}

TEST(ReadFile, RefusesWhatIsNoFile) {
  const TemporaryFolder folder;
  const std::filesystem::path absent = folder.path() / "absent";
  EXPECT_THROW(readFile(absent), InputError);
  EXPECT_THAT(messageOf<Error>([&] { readFile(absent); }),
              AllOf(StartsWith(absent.string() + ": "), HasSubstr("No such file")));
  EXPECT_THAT(messageOf<Error>([&] { readFile(folder.path()); }),
              StartsWith(folder.path().string() + ": is not a file"));
  EXPECT_THROW(readFile(""), InputError);
  EXPECT_THROW(readFile("/dev/zero"), InputError);
  const std::filesystem::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(readFile(pipe), InputError);
}

TEST(AtomicFile, IsThereOnlyAfterCommit) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.txt";
  AtomicFile file(path);
  file.write("one ");
  file.write("");
  file.write("two");
  EXPECT_EQ(file.size(), 7u);
  EXPECT_FALSE(std::filesystem::exists(path));
  file.commit();
  EXPECT_EQ(content(path), "one two");
  EXPECT_EQ(entries(folder.path()), 1u);
}

TEST(AtomicFile, LeavesNothingWithoutCommit) {
  const TemporaryFolder folder;
  { AtomicFile(folder.path() / "a.txt").write("half"); }
  EXPECT_EQ(entries(folder.path()), 0u);
  const std::filesystem::path existing = folder.write("b.txt", "old");
  try {
    AtomicFile file(existing);
    file.write("half");
    throw Error("interrupted");
  } catch (const Error&) {
  }
  EXPECT_EQ(content(existing), "old");
  EXPECT_EQ(entries(folder.path()), 1u);
}

TEST(AtomicFile, ReplacesAWholeFile) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("a.txt", "a long old text");
  const std::filesystem::path linked = folder.path() / "b.txt";
  std::filesystem::create_hard_link(path, linked);
  writeFile(path, "new");
  EXPECT_EQ(content(path), "new");
  EXPECT_EQ(content(linked), "a long old text") << "a reader of the old file keeps it";
  EXPECT_EQ(entries(folder.path()), 2u);
}

TEST(AtomicFile, MakesTheFolderThatIsMissing) {
  const TemporaryFolder folder;
  writeFile(folder.path() / "absent" / "below" / "a.txt", "x");
  EXPECT_EQ(content(folder.path() / "absent" / "below" / "a.txt"), "x");
}

TEST(AtomicFile, NamesThePathItCannotWrite) {
  const TemporaryFolder folder;
  const std::filesystem::path belowAFile = folder.write("file", "") / "a.txt";
  EXPECT_THAT(messageOf<Error>([&] { writeFile(belowAFile, "x"); }),
              AllOf(StartsWith(belowAFile.string() + ": cannot be written: "), HasSubstr("Not a directory")));
  EXPECT_THAT(messageOf<Error>([&] { AtomicFile file(folder.path()); }), StartsWith(folder.path().string()));
}

TEST(AtomicFile, NeverReplacesADevice) {
  EXPECT_THAT(messageOf<Error>([] { AtomicFile file("/dev/full"); }), StartsWith("/dev/full: cannot be written"));
  struct stat status {};
  ASSERT_EQ(::stat("/dev/full", &status), 0);
  EXPECT_TRUE(S_ISCHR(status.st_mode));
}

// The limit on a file's size stands for any write that fails half-way, such as on a full disk; every system has it.
TEST(AtomicFile, AFailedWriteLeavesTheOldFile) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("a.bin", "old");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 4096;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = messageOf<Error>([&] { writeFile(path, std::string(100'000, 'x')); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(message, path.string() + ": cannot be written: File too large");
  EXPECT_EQ(content(path), "old");
  EXPECT_EQ(entries(folder.path()), 1u);
}

}  // namespace
}  // namespace scanmill
