#include "tests/commands/program.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <thread>

#include "base/file.h"

namespace scanmill {

std::string testedProgram() {
  return SCANMILL_PROGRAM;
}

RunningProgram::RunningProgram(std::vector<std::string> command, const std::vector<std::string>& variables) {
  const std::string out = (folder_.path() / "out").string();
  const std::string error = (folder_.path() / "error").string();
  std::vector<char*> argv;
  for (std::string& word : command) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::vector<std::string> added = variables;
  pid_ = ::fork();
  if (pid_ != 0) return;
  // Nothing here may touch the streams of the tests, of which this process has a copy.
  for (std::string& variable : added) ::putenv(variable.data());
  const int outFile = ::open(out.c_str(), O_WRONLY | O_CREAT, 0600);
  const int errorFile = ::open(error.c_str(), O_WRONLY | O_CREAT, 0600);
  if (::dup2(outFile, STDOUT_FILENO) < 0 || ::dup2(errorFile, STDERR_FILENO) < 0) ::_exit(126);
  ::execvp(argv[0], argv.data());
  ::_exit(127);
}

RunningProgram::~RunningProgram() {
  if (ended_ || pid_ < 0) return;
  send(SIGKILL);
  reap(true);
}

void RunningProgram::send(int signal) const {
  ::kill(pid_, signal);
}

bool RunningProgram::reap(bool block) {
  int status = 0;
  rusage usage{};
  if (ended_ || ::wait4(pid_, &status, block ? 0 : WNOHANG, &usage) != pid_) return ended_;
  ended_ = true;
  outcome_.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome_.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  outcome_.peakBytes = usage.ru_maxrss * 1024;
  outcome_.out = readFile(folder_.path() / "out");
  outcome_.error = readFile(folder_.path() / "error");
  return true;
}

bool RunningProgram::running() {
  return !reap(false);
}

Outcome RunningProgram::wait(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!reap(false)) {
    if (std::chrono::steady_clock::now() > end) {
      outcome_.late = true;
      send(SIGKILL);
      reap(true);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return outcome_;
}

Outcome scanmill(const std::vector<std::string>& arguments, const std::vector<std::string>& variables) {
  std::vector<std::string> command{testedProgram()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return RunningProgram(command, variables).wait();
}

std::vector<std::string> withSettings(std::vector<std::string> arguments, const std::vector<std::string>& settings,
                                      const std::vector<std::string>& more) {
  for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> wordsOf(const std::string& command) {
  std::vector<std::string> words(1);
  bool quoted = false;
  for (const char c : command) {
    if (c == '\'') {
      quoted = !quoted;
    } else if (c == ' ' && !quoted) {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

std::vector<Outcome> scanmillEach(const std::vector<std::vector<std::string>>& arguments) {
  constexpr std::size_t kAtATime = 4;
  std::vector<Outcome> outcomes;
  for (std::size_t first = 0; first < arguments.size(); first += kAtATime) {
    std::vector<std::unique_ptr<RunningProgram>> processes;
    for (std::size_t i = first; i < std::min(first + kAtATime, arguments.size()); ++i) {
      std::vector<std::string> command{testedProgram()};
      command.insert(command.end(), arguments[i].begin(), arguments[i].end());
      processes.push_back(std::make_unique<RunningProgram>(command));
    }
    for (const auto& process : processes) outcomes.push_back(process->wait());
  }
  return outcomes;
}

void expectRefused(const Outcome& outcome, const std::string& text) {
  EXPECT_EQ(outcome.code, 2) << "signal " << outcome.signal << (outcome.late ? " (too late)" : "") << "\n"
                             << outcome.error;
  EXPECT_THAT(outcome.error, testing::HasSubstr("error: "));
  EXPECT_THAT(outcome.error, testing::HasSubstr(text));
  EXPECT_EQ(outcome.out, "");
}

SmallWorld::SmallWorld() {
  folder_.write("scene.yaml", fmt::format(R"(ontology: {0}/labels/scanmill.yaml
materials: {0}/labels/materials.yaml
objects:
  - {{name: floor, primitive: plane, size: [100, 100], class: ground, material: concrete}}
  - {{name: wall, primitive: box, size: [1, 60, 9], class: wall, material: brick, position: [20, 0, 4]}}
  - {{name: car, primitive: box, size: [4, 2, 2], class: car, material: painted_metal, position: [9, 4, 1]}}
)",
                                          SCANMILL_SOURCE_DIR));
  pipeline_ = folder_
                  .write("small.yaml", R"(name: small
scenes: [{scene: scene.yaml}]
trajectories: [{name: drive, waypoints: [[-10, 0, 0], [10, 0, 0]], speed: 10, every_s: 0.1, frames: 4}]
sensors:
  - name: top
    columns: 64
    rate_hz: 10
    elevation_deg: {top: 5, bottom: -25, rings: 8}
    range_m: [0.5, 100]
    mount: {position: [0, 0, 1.8]}
method: ray_tracing
effects: [intensity]
output: {formats: [pcd, draco, csv], shard_samples: 100}
)")
                  .string();
}

std::vector<std::filesystem::path> SmallWorld::filesEndingIn(const std::string& suffix,
                                                             const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_directory() && entry.path().string().ends_with(suffix)) files.push_back(entry.path());
  }
  return files;
}

}  // namespace scanmill
