#pragma once

// Runs other programs as child processes, and returns the name of this host.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {

// Returns the name of this host, or "this host" if it has none.
std::string hostName();

// Returns the executable file that a shell would start for `name`: a name without a slash is looked for in PATH.
// Returns an empty path if there is no such file.
std::filesystem::path findProgram(const std::string& name);

// Thrown if the event that a call waits for does not happen in time. The child still runs.
class TimeOut : public Error {
 public:
  using Error::Error;
};

// A child process, started without a shell, so that its command is not parsed again. It has no open file descriptors
// but its three standard streams. Standard input and output are one socket; a script that opens /dev/stdout therefore
// fails. The destructor kills the child and the processes that the child has started. If this program dies without
// running the destructor, the child sees the end of its standard input. All times are seconds of wall-clock time.
class Process {
 public:
  // `command` is the program and its arguments; `environment` is added to this program's own environment. Throws Error
  // if the program cannot be started.
  explicit Process(const std::vector<std::string>& command, const std::map<std::string, std::string>& environment = {});
  ~Process();
  Process& operator=(Process&&) = delete;  // neither copied nor moved

  // Writes a text to the child's standard input: at most 64 KiB, which the system buffers. If the child has closed its
  // input, the text is dropped without an error.
  void write(std::string_view text);
  // Waits for the next line of the child's standard output and returns it without its line feed; nullopt if the output
  // has ended. Throws TimeOut after `seconds`, and Error for a line of over 16 MiB.
  std::optional<std::string> readLine(double seconds);
  // Waits until the child has ended and returns how it ended: "exit code 3", "signal 11 (Segmentation fault)". Throws
  // TimeOut after `seconds`. Output that was not read is kept, up to 16 MiB; further output is dropped.
  std::string wait(double seconds);
  // Returns the last lines of the child's standard error, at most twelve lines and 4 KiB.
  std::string lastLines() const;

 private:
  bool reap(bool block);
  void receive(double seconds);

  std::string name_;
  int pid_ = -1;  // -1: waitpid() has returned the child's status
  int status_ = 0;
  Descriptor socket_;   // connected to the child's standard input and output
  Descriptor errors_;   // file with the child's standard error
  std::string output_;  // output that was received but not yet returned by readLine()
};

}  // namespace scanmill
