#include "base/folder_lock.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "base/error.h"
#include "base/file.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class FolderLockTest : public testing::Test {
 protected:
  std::unique_ptr<FolderLock> take(LockKind kind) {
    holder_.clear();
    return FolderLock::tryTake(folder_.path(), file_, kind, holder_);
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "lock";
  std::string holder_;
};

TEST_F(FolderLockTest, OneAloneOrSeveralTogether) {
  {
    const auto alone = take(LockKind::Alone);
    ASSERT_NE(alone, nullptr);
    EXPECT_EQ(take(LockKind::Alone), nullptr);
    EXPECT_THAT(holder_, AllOf(HasSubstr("process " + std::to_string(::getpid())), HasSubstr("since")));
    EXPECT_EQ(take(LockKind::Shared), nullptr);
    EXPECT_THAT(messageOf<InputError>([&] { FolderLock(folder_.path(), file_); }),
                AllOf(HasSubstr(folder_.path().string()), HasSubstr("is being written by process")));
  }
  EXPECT_FALSE(std::filesystem::exists(file_));
  auto one = take(LockKind::Shared);
  const auto two = take(LockKind::Shared);
  ASSERT_NE(one, nullptr);
  ASSERT_NE(two, nullptr);
  EXPECT_EQ(take(LockKind::Alone), nullptr);
  one.reset();
  EXPECT_TRUE(std::filesystem::exists(file_)) << "the other one holds it still";
  EXPECT_EQ(take(LockKind::Alone), nullptr);
}

TEST_F(FolderLockTest, TheLastOneThatSharesItMayHaveItAlone) {
  auto one = take(LockKind::Shared);
  auto two = take(LockKind::Shared);
  EXPECT_FALSE(one->makeAlone());
  EXPECT_TRUE(two->makeAlone()) << "who failed holds nothing any more";
  EXPECT_EQ(take(LockKind::Shared), nullptr);
  two.reset();
  EXPECT_FALSE(std::filesystem::exists(file_));
  one.reset();
  EXPECT_NE(take(LockKind::Alone), nullptr);
}

// A file that another process has removed and made again is another lock.
TEST_F(FolderLockTest, ALockWhoseFileIsGoneIsNoneToBuildOn) {
  auto one = take(LockKind::Shared);
  std::filesystem::remove(file_);
  const auto two = take(LockKind::Alone);
  ASSERT_NE(two, nullptr);
  EXPECT_FALSE(one->makeAlone());
  one.reset();
  EXPECT_TRUE(std::filesystem::exists(file_));
}

TEST_F(FolderLockTest, ADeadProcessHoldsNothing) {
  for (const LockKind kind : {LockKind::Alone, LockKind::Shared}) {
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const auto held = take(kind);
      [[maybe_unused]] const auto told = ::write(ready[1], "x", 1);
      ::pause();
    }
    char letter = 0;
    ASSERT_EQ(::read(ready[0], &letter, 1), 1);
    EXPECT_EQ(take(LockKind::Alone), nullptr);
    EXPECT_THAT(holder_, HasSubstr("process " + std::to_string(child)));
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_NE(take(LockKind::Alone), nullptr);
  }
}

// A dataset may come from somebody else, with links in it.
TEST_F(FolderLockTest, NothingIsWrittenThroughLinks) {
  const std::filesystem::path precious = folder_.write("precious", "precious");
  const auto refused = [&](const std::filesystem::path& named, const char* what) {
    std::string holder;
    const std::string message = messageOf<ForeignFile>([&] {
      static_cast<void>(FolderLock::tryTake(folder_.path(), folder_.path() / "own/lock", LockKind::Alone, holder));
    });
    EXPECT_THAT(message, AllOf(HasSubstr((folder_.path() / named).string()), HasSubstr(what), HasSubstr("remove it")));
    EXPECT_EQ(readFile(precious), "precious");
    std::filesystem::remove_all(folder_.path() / "own");
  };
  const std::filesystem::path own = folder_.path() / "own";
  std::filesystem::create_directory(own);
  std::filesystem::create_symlink(precious, own / "lock");
  refused("own/lock", "a link");
  std::filesystem::create_directory(own);
  std::filesystem::create_symlink(folder_.path() / "nowhere", own / "lock");
  refused("own/lock", "a link");
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "nowhere"));
  std::filesystem::create_directory(own);
  std::filesystem::create_hard_link(precious, own / "lock");
  refused("own/lock", "another name");
  std::filesystem::create_directories(own / "lock");
  refused("own/lock", "a folder");
  std::filesystem::create_directory(own);
  ASSERT_EQ(::mkfifo((own / "lock").c_str(), 0600), 0);
  refused("own/lock", "not a file");
  std::filesystem::create_directory(folder_.path() / "elsewhere");
  std::filesystem::create_directory_symlink(folder_.path() / "elsewhere", own);
  refused("own", "is a link or a file");
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path() / "elsewhere"));
}

TEST_F(FolderLockTest, TheFolderItselfMayBeALink) {
  const std::filesystem::path named = folder_.path() / "named";
  std::filesystem::create_directory(folder_.path() / "meant");
  std::filesystem::create_directory_symlink("meant", named);
  std::string holder;
  const auto lock = FolderLock::tryTake(named, named / "lock", LockKind::Alone, holder);
  EXPECT_NE(lock, nullptr);
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "meant/lock"));
}

}  // namespace
}  // namespace scanmill
