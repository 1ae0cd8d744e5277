#include "scene/assets/trial.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>

#include "base/error.h"

namespace scanmill {

namespace {

void limit(int resource, std::uint64_t value) {
  rlimit limits{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limits) != 0) return;
  limits.rlim_cur = std::min<rlim_t>(value, limits.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &limits);
}

std::uint64_t addressSpace() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void silence() {
  const int nowhere = ::open("/dev/null", O_WRONLY);
  if (nowhere < 0) return;
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
}

[[noreturn]] void runChild(const std::function<std::string()>& work, int answer) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGXCPU}) std::signal(signal, SIG_DFL);
  std::string text;
  try {
    text = work();
  } catch (const std::exception& e) {
    text = e.what();
  } catch (...) {
    text = "it failed for no stated reason";
  }
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(answer, text.data() + done, text.size() - done);
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  ::_exit(0);  // neither buffers nor destructors of the parent are the child's
}

std::string readAll(int descriptor) {
  std::string text;
  std::array<char, 4096> block;
  for (;;) {
    const ssize_t n = ::read(descriptor, block.data(), block.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return text;
    text.append(block.data(), static_cast<std::size_t>(n));
  }
}

}  // namespace

std::string tryApart(const std::function<std::string()>& work, std::uint64_t memory, unsigned seconds) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) throw Error(fmt::format("no pipe: {}", std::strerror(errno)));
  const std::uint64_t space = addressSpace();
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(pipe[0]);
    ::close(pipe[1]);
    throw Error(fmt::format("no child process: {}", std::strerror(errno)));
  }
  if (child == 0) {
    silence();
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_AS, space + memory);
    limit(RLIMIT_CPU, seconds);
    runChild(work, pipe[1]);
  }
  ::close(pipe[1]);
  std::string text = readAll(pipe[0]);
  ::close(pipe[0]);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) != 0 && text.empty()) return "it ends the importer";
  if (!WIFSIGNALED(status)) return text;
  if (WTERMSIG(status) == SIGXCPU) return fmt::format("it takes more than {} s", seconds);
  return fmt::format("it brings the importer down (signal {})", WTERMSIG(status));
}

}  // namespace scanmill
