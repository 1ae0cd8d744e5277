#pragma once

// Runs the program as a user does.

#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace scanmill {

struct Outcome {
  int code = -1;       // exit code; -1 where a signal ended the program
  int signal = 0;      // that ended it
  bool late = false;   // it was killed since it took too long
  std::string out;     // standard output
  std::string error;   // standard error
  long peakBytes = 0;  // resident
};

// A program in the background. Its output goes to files, so that it never waits for a reader.
class RunningProgram {
 public:
  // `variables` such as "NAME=value" are added to the environment.
  explicit RunningProgram(std::vector<std::string> command, const std::vector<std::string>& variables = {});
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  void send(int signal) const;
  bool running();
  // Waits for the end of the program, which is killed after so many seconds.
  Outcome wait(double seconds = 60);

 private:
  bool reap(bool block);

  TemporaryFolder folder_;
  int pid_ = -1;
  bool ended_ = false;
  Outcome outcome_;
};

// Returns the path of the program that was built with the tests.
std::string testedProgram();

// `scanmill ARGUMENTS`, to its end.
Outcome scanmill(const std::vector<std::string>& arguments, const std::vector<std::string>& variables = {});

// `arguments`, then `--set` before each of the settings, then `more`.
std::vector<std::string> withSettings(std::vector<std::string> arguments, const std::vector<std::string>& settings,
                                      const std::vector<std::string>& more = {});

// Returns the words of a command, which blanks separate; '...' is one word.
std::vector<std::string> wordsOf(const std::string& command);

// Several, some at a time.
std::vector<Outcome> scanmillEach(const std::vector<std::vector<std::string>>& arguments);

// The program refused its input: exit code 2, a line on standard error that holds `text`, nothing on standard output.
void expectRefused(const Outcome& outcome, const std::string& text);

// A small scene and pipeline in a temporary folder.
class SmallWorld : public testing::Test {
 protected:
  SmallWorld();
  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }
  // Every file in a folder, below it too, whose name ends so.
  static std::vector<std::filesystem::path> filesEndingIn(const std::string& suffix,
                                                          const std::filesystem::path& folder);

  TemporaryFolder folder_;
  std::string pipeline_;  // 8 x 64 beams, 4 frames
};

}  // namespace scanmill
