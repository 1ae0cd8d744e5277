#pragma once

// Other programs, run as children.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace scanmill {

// The program that a shell would start by this name: an executable file, looked for in PATH where the name has no
// slash. Empty where there is none.
std::filesystem::path findProgram(const std::string& name);

// The child did not do in time what was waited for. It still runs.
class TimeOut : public Error {
 public:
  using Error::Error;
};

// A child, started without a shell: its words are never parsed again. It has its three standard streams and no other
// descriptor of ours, and is killed, with what it started itself, when its owner goes away. Should this program end
// before that, the child sees the end of its standard input. All seconds are of wall-clock time.
class Process {
 public:
  // `environment` is added to this program's own. Throws Error where the program cannot be started.
  explicit Process(const std::vector<std::string>& command, const std::map<std::string, std::string>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  // To its standard input; what a child that has closed it does not take is lost. Throws TimeOut.
  void write(std::string_view text, double seconds);
  void closeInput();
  // The next line of its standard output, without its end; nullopt where there is no further one. Throws TimeOut, and
  // Error for a line of over 16 MiB.
  std::optional<std::string> readLine(double seconds);
  // Waits until it has ended and says how: "exit code 3", "signal 11 (Segmentation fault)". Throws TimeOut.
  std::string wait(double seconds);
  // What it last wrote to its standard error, a dozen lines at most, as far as the other calls have come across it.
  std::string lastLines() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
