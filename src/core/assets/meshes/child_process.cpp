#include "assets/meshes/child_process.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <stdexcept>
#include <utility>

#include "base/file.h"

namespace scanmill {

namespace {

constexpr int kPipeBytes = 1 << 18;

// Sets a limit (RLIMIT_...) of this process to `value`, or to the hard limit if this is lower.
void setLimit(int resource, std::uint64_t value) {
  rlimit limits{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limits) != 0) return;
  limits.rlim_cur = std::min<rlim_t>(value, limits.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &limits);
}

// Returns the size of this process's address space (bytes).
std::uint64_t addressSpace() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void discardOutput() {
  const int nullDevice = ::open("/dev/null", O_WRONLY);
  if (nullDevice < 0) return;
  ::dup2(nullDevice, STDOUT_FILENO);
  ::dup2(nullDevice, STDERR_FILENO);
}

// Exit codes of the child, if no signal ends it.
enum ExitCode { Done = 0, Failed = 3, OutOfMemory = 4, NobodyListens = 5 };

// Runs in the child: calls `work`, writes its result or the message of its exception to `pipe`, and exits.
[[noreturn]] void runChild(const std::function<std::string()>& work, int pipe) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGXCPU}) std::signal(signal, SIG_DFL);
  std::string text;
  int code = Done;
  try {
    text = work();
  } catch (const std::bad_alloc&) {
    code = OutOfMemory;
  } catch (const std::length_error&) {  // a size that no memory could hold
    code = OutOfMemory;
  } catch (const std::exception& e) {
    text = reasonOf(e);
    code = Failed;
  } catch (...) {
    text = "it failed without a stated reason";
    code = Failed;
  }
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t bytes = ::write(pipe, text.data() + written, text.size() - written);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) ::_exit(NobodyListens);
    written += static_cast<std::size_t>(bytes);
  }
  ::_exit(code);  // not exit(), which would flush the parent's buffers and run its destructors
}

// Reads from a pipe until all writers have closed it, and returns the bytes.
std::string readAll(int descriptor) {
  std::string text;
  std::array<char, kPipeBytes> block;
  for (;;) {
    const ssize_t bytes = ::read(descriptor, block.data(), block.size());
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) return text;
    text.append(block.data(), static_cast<std::size_t>(bytes));
  }
}

// Waits for the end of a child process that sent `text`, and returns `text`. Throws as inChildProcess() does; messages
// name the limits `memory` and `seconds`.
std::string resultOf(pid_t child, std::string text, std::uint64_t memory, unsigned seconds) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    if (WTERMSIG(status) == SIGXCPU) throw ChildEnded(fmt::format("it takes more than {} s", seconds));
    throw ChildEnded(fmt::format("it crashes the importer (signal {})", WTERMSIG(status)));
  }
  switch (WEXITSTATUS(status)) {
    case Done:
      return text;
    case Failed:
      throw Error(text);
    case OutOfMemory:
      throw ChildEnded(fmt::format("it takes more than {:.1f} GB of memory", static_cast<double>(memory) * 1e-9));
    default:
      throw ChildEnded("it makes the importer exit");
  }
}

}  // namespace

std::string inChildProcess(const std::function<std::string()>& work, std::uint64_t memory, unsigned seconds) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) throw Error("a pipe cannot be made: {}", std::strerror(errno));
  Descriptor readEnd(pipe[0]);
  Descriptor writeEnd(pipe[1]);
  ::fcntl(writeEnd.number, F_SETPIPE_SZ, kPipeBytes);  // may fail: a smaller pipe is only slower
  const std::uint64_t parentSpace = addressSpace();
  const pid_t child = ::fork();
  if (child < 0) throw Error("a child process cannot be started: {}", std::strerror(errno));
  if (child == 0) {
    readEnd.close();
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    discardOutput();
    setLimit(RLIMIT_CORE, 0);
    setLimit(RLIMIT_AS, parentSpace + memory);
    setLimit(RLIMIT_CPU, seconds);
    runChild(work, writeEnd.number);
  }
  writeEnd.close();
  std::string text = readAll(readEnd.number);
  readEnd.close();
  return resultOf(child, std::move(text), memory, seconds);
}

}  // namespace scanmill
