#include "base/process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <thread>

#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

std::size_t openDescriptors() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

// Whether a process of this number runs; a zombie does not.
bool runs(int pid) {
  std::FILE* status = std::fopen(("/proc/" + std::to_string(pid) + "/stat").c_str(), "r");
  if (status == nullptr) return false;
  char state = 'Z';
  const int fields = std::fscanf(status, "%*d (%*[^)]) %c", &state);
  std::fclose(status);
  return fields == 1 && state != 'Z';
}

bool endsSoon(int pid) {
  for (int i = 0; i < 500 && runs(pid); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return !runs(pid);
}

TEST(Process, AnswersLineByLine) {
  Process cat({"cat"});
  cat.write("one\ntwo\n");
  EXPECT_EQ(cat.readLine(10), "one");
  EXPECT_EQ(cat.readLine(10), "two");
}

TEST(Process, TheLastLineNeedsNoLineFeed) {
  Process printf({"printf", "one\ntwo"});
  EXPECT_EQ(printf.readLine(10), "one");
  EXPECT_EQ(printf.readLine(10), "two");
  EXPECT_EQ(printf.readLine(10), std::nullopt);
  EXPECT_EQ(printf.wait(10), "exit code 0");
  EXPECT_EQ(printf.wait(10), "exit code 0") << "asked again";
}

TEST(Process, WhatWePrintDoesNotReachItWhereOurOutputIsClosed) {
  std::array<int, 2> kept{};
  for (const int number : {STDOUT_FILENO, STDERR_FILENO}) {
    kept[static_cast<std::size_t>(number - 1)] = ::fcntl(number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    ::close(number);
  }
  Process cat({"cat"});
  const std::array<ssize_t, 2> written{::write(STDOUT_FILENO, "stray\n", 6), ::write(STDERR_FILENO, "stray\n", 6)};
  for (const int number : {STDOUT_FILENO, STDERR_FILENO}) {
    ::dup2(kept[static_cast<std::size_t>(number - 1)], number);
    ::close(kept[static_cast<std::size_t>(number - 1)]);
  }
  EXPECT_THAT(written, testing::Each(-1));
  cat.write("one\n");
  EXPECT_EQ(cat.readLine(10), "one");
}

TEST(Process, WordsReachTheProgramAsTheyAre) {
  Process printf({"printf", "%s\n", "a b", "$HOME; echo 'x' `id`", "", "*"});
  EXPECT_EQ(printf.readLine(10), "a b");
  EXPECT_EQ(printf.readLine(10), "$HOME; echo 'x' `id`");
  EXPECT_EQ(printf.readLine(10), "");
  EXPECT_EQ(printf.readLine(10), "*");
  EXPECT_EQ(printf.readLine(10), std::nullopt);
}

TEST(Process, EnvironmentIsAddedToOurs) {
  ::setenv("SCANMILL_TEST_KEPT", "kept", 1);
  ::setenv("SCANMILL_TEST_CHANGED", "before", 1);
  Process shell({"sh", "-c", "echo $SCANMILL_TEST_KEPT $SCANMILL_TEST_CHANGED"}, {{"SCANMILL_TEST_CHANGED", "after"}});
  EXPECT_EQ(shell.readLine(10), "kept after");
}

TEST(Process, SaysHowItEnded) {
  EXPECT_EQ(Process({"sh", "-c", "exit 3"}).wait(10), "exit code 3");
  EXPECT_THAT(Process({"sh", "-c", "kill -SEGV $$"}).wait(10), HasSubstr("signal 11"));
}

TEST(Process, KeepsTheLastLinesOfItsErrors) {
  Process shell(
      {"sh", "-c", "for i in $(seq 1 5000); do echo \"line $i of many\" >&2; done; printf last >&2; echo done"});
  EXPECT_EQ(shell.readLine(10), "done");
  shell.wait(10);
  EXPECT_THAT(shell.lastLines(), HasSubstr("line 5000 of many\nlast"));
  EXPECT_EQ(shell.lastLines().find("line 4000 "), std::string::npos);
}

TEST(Process, TimesOut) {
  Process sleep({"sleep", "100"});
  EXPECT_THROW(sleep.readLine(0.05), TimeOut);
  EXPECT_THROW(sleep.wait(0.05), TimeOut);
}

TEST(Process, WritingToOneThatHasEndedIsHarmless) {
  Process gone({"true"});
  EXPECT_EQ(gone.readLine(10), std::nullopt);
  gone.write("too late\n");
  EXPECT_EQ(gone.wait(10), "exit code 0");
}

TEST(Process, DiesWithItsOwnerAndTakesItsChildrenAlong) {
  int parent = 0;
  int child = 0;
  {
    Process shell({"sh", "-c", "sleep 1000 & echo $$; echo $!; wait"});
    parent = std::stoi(shell.readLine(10).value());
    child = std::stoi(shell.readLine(10).value());
    EXPECT_TRUE(runs(parent));
    EXPECT_TRUE(runs(child));
  }
  EXPECT_FALSE(std::filesystem::exists("/proc/" + std::to_string(parent))) << "a zombie is left";
  EXPECT_TRUE(endsSoon(child));
}

TEST(Process, WhatItLeavesBehindDoesNotHoldUs) {
  Process shell({"sh", "-c", "sleep 1000 & echo $!"});
  const int child = std::stoi(shell.readLine(10).value());
  EXPECT_EQ(shell.readLine(10), std::nullopt);
  EXPECT_EQ(shell.wait(10), "exit code 0");
  EXPECT_TRUE(endsSoon(child));
}

TEST(Process, LeaksNoDescriptorEitherWay) {
  const std::size_t before = openDescriptors();
  const int ours = ::open("/dev/null", O_RDONLY);  // without O_CLOEXEC
  {
    Process list({"sh", "-c", "ls /proc/self/fd | wc -l"});
    EXPECT_EQ(list.readLine(10), "4") << "0, 1, 2 and the folder that is listed";
    Process other({"sh", "-c", "ls /proc/self/fd | wc -l"});
    EXPECT_EQ(other.readLine(10), "4");
  }
  EXPECT_ANY_THROW(Process({"/no/such/program"}));
  ::close(ours);
  EXPECT_EQ(openDescriptors(), before);
}

TEST(Process, NamesAProgramThatCannotBeStarted) {
  const TemporaryFolder folder;
  const auto file = folder.write("text", "no program");
  EXPECT_THAT(messageOf<Error>([] { Process({"/no/such/program"}); }),
              testing::AllOf(HasSubstr("/no/such/program"), HasSubstr("cannot be started"), HasSubstr("No such file")));
  EXPECT_THAT(messageOf<Error>([&] { Process({file.string()}); }), HasSubstr("Permission denied"));
}

TEST(Process, SeesTheEndOfItsInputWhenWeAreKilled) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t owner = ::fork();
  if (owner == 0) {
    Process shell({"sh", "-c", "echo $$; exec cat"});
    const int pid = std::stoi(shell.readLine(10).value_or("0"));
    const bool told = ::write(pipe[1], &pid, sizeof pid) == sizeof pid;
    ::raise(told ? SIGKILL : SIGABRT);
  }
  int inner = 0;
  ASSERT_EQ(::read(pipe[0], &inner, sizeof inner), static_cast<ssize_t>(sizeof inner));
  int status = 0;
  ::waitpid(owner, &status, 0);
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
  ASSERT_GT(inner, 0);
  EXPECT_TRUE(endsSoon(inner));
  for (const int end : pipe) ::close(end);
}

TEST(FindProgram, AsAShellDoes) {
  const TemporaryFolder folder;
  const auto program = folder.write("scanmill-test-program", "#!/bin/sh\necho found\n");
  EXPECT_EQ(findProgram(program.string()), "") << "not executable";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  EXPECT_EQ(findProgram(program.string()), program);
  EXPECT_EQ(findProgram("scanmill-test-program"), "");
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (path + ":" + folder.path().string()).c_str(), 1);
  EXPECT_EQ(findProgram("scanmill-test-program"), program);
  EXPECT_EQ(Process({"scanmill-test-program"}).readLine(10), "found");
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(findProgram(""), "");
  EXPECT_EQ(findProgram(folder.path().string()), "") << "a folder";
}

}  // namespace
}  // namespace scanmill
