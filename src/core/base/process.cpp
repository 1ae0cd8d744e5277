#include "base/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "base/stage_clock.h"
#include "base/text_scan.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostLineBytes = std::size_t{16} << 20;
constexpr double kLongestPoll = 0.05;  // s; after this time without output it is checked whether the child has ended

// Creates an unnamed temporary file, whose descriptor is above those of the standard streams. Throws Error.
Descriptor makeFile() {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  if (file == nullptr) throw Error("no temporary file: " + std::string(std::strerror(errno)));
  return Descriptor(::fcntl(::fileno(file.get()), F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
}

// Owns the arguments of posix_spawn(). The child gets a new process group, and no signal is blocked or handled.
struct SpawnActions {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;

  SpawnActions() {
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawnattr_init(&attributes);
    sigset_t none;
    sigset_t all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setsigdefault(&attributes, &all);
    ::posix_spawnattr_setpgroup(&attributes, 0);  // a new process group, so that the child's children are killed too
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnActions() {
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
  }
  SpawnActions& operator=(SpawnActions&&) = delete;  // neither copied nor moved
};

// Returns pointers to the texts, and a null pointer, as execve() takes them. The texts must outlive the pointers.
std::vector<char*> pointersTo(std::vector<std::string>& texts) {
  std::vector<char*> pointers(texts.size() + 1, nullptr);
  std::ranges::transform(texts, pointers.begin(), [](std::string& text) { return text.data(); });
  return pointers;
}

// Returns this program's environment, in which `changes` replace or add variables, as texts NAME=VALUE.
std::vector<std::string> environmentWith(const std::map<std::string, std::string>& changes) {
  std::vector<std::string> variables;
  for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    if (!changes.contains(std::string(text.substr(0, text.find('='))))) variables.emplace_back(text);
  }
  for (const auto& [name, value] : changes) variables.push_back(name + "=" + value);
  return variables;
}

bool isProgram(const std::filesystem::path& path) {
  return isFile(path) && ::access(path.c_str(), X_OK) == 0;
}

}  // namespace

std::string hostName() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "this host";
  return name.data();
}

std::filesystem::path findProgram(const std::string& name) {
  if (name.empty()) return {};
  if (name.find('/') != std::string::npos) return isProgram(name) ? std::filesystem::path(name) : "";
  const char* path = std::getenv("PATH");
  const std::string_view folders = path != nullptr ? path : "/usr/local/bin:/usr/bin:/bin";
  for (std::size_t begin = 0; begin <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    // An empty name in PATH means the current folder.
    const std::filesystem::path folder = end == begin ? "." : folders.substr(begin, end - begin);
    if (isProgram(folder / name)) return folder / name;
    begin = end + 1;
  }
  return {};
}

Process::Process(const std::vector<std::string>& command, const std::map<std::string, std::string>& environment)
    : name_(command.at(0)), errors_(makeFile()) {
  // Uses a socket, because writing to a pipe whose reader has ended raises a fatal signal (SIGPIPE).
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw Error("no socket: " + std::string(std::strerror(errno)));
  const Descriptor ownEnd(ends[0]);
  const Descriptor childEnd(ends[1]);
  // In place of a closed standard stream, the socket would get this program's own output: take a higher number.
  socket_ = Descriptor(::fcntl(ownEnd.number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
  if (!socket_.open()) throw Error("no socket: " + std::string(std::strerror(errno)));
  SpawnActions actions;
  ::posix_spawn_file_actions_adddup2(&actions.files, childEnd.number, STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions.files, childEnd.number, STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions.files, errors_.number, STDERR_FILENO);
  ::posix_spawn_file_actions_addclosefrom_np(&actions.files, STDERR_FILENO + 1);
  std::vector<std::string> words = command;
  std::vector<std::string> variables = environmentWith(environment);
  const int failure = ::posix_spawnp(&pid_, words[0].c_str(), &actions.files, &actions.attributes,
                                     pointersTo(words).data(), pointersTo(variables).data());
  if (failure != 0) throw Error("{}: cannot be started: {}", name_, std::strerror(failure));
}

Process::~Process() {
  if (pid_ < 0) return;
  ::kill(-pid_, SIGKILL);
  reap(true);
}

// True if the child has ended; then kills the processes that it left running. `block`: waits for the child's end.
bool Process::reap(bool block) {
  if (pid_ < 0) return true;
  siginfo_t ended{};
  int result = 0;
  do {
    result = ::waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOWAIT | (block ? 0 : WNOHANG));
  } while (result != 0 && errno == EINTR);
  if (result == 0 && ended.si_pid == 0) return false;
  if (result == 0) ::kill(-pid_, SIGKILL);  // kills the group before waitpid() frees its number
  while (::waitpid(pid_, &status_, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return true;
}

// Waits for output, at most `seconds`, and appends it to output_. Closes the socket at the end of the output, and when
// the child has ended and left no output.
void Process::receive(double seconds) {
  const bool ended = reap(false);
  pollfd polled{socket_.number, POLLIN, 0};
  const int ready = ::poll(&polled, 1, ended ? 0 : static_cast<int>(std::ceil(seconds * 1000)));
  if (ready < 0 && errno == EINTR) return;
  if (ready < 0) throw Error("{}: cannot be waited for: {}", name_, std::strerror(errno));
  std::array<char, 1 << 16> block;
  const ssize_t n = ready > 0 ? ::recv(socket_.number, block.data(), block.size(), MSG_DONTWAIT) : 0;
  if (n > 0 && output_.size() <= kMostLineBytes) output_.append(block.data(), static_cast<std::size_t>(n));
  if (n < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (n <= 0 && (ready > 0 || ended)) socket_.close();
}

void Process::write(std::string_view text) {
  while (!text.empty() && socket_.open()) {
    const ssize_t n = ::send(socket_.number, text.data(), text.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

std::optional<std::string> Process::readLine(double seconds) {
  const WallTimer timer;
  while (true) {
    const std::size_t newline = output_.find('\n');
    if (newline != std::string::npos || (!socket_.open() && !output_.empty())) {
      std::string line = output_.substr(0, newline);
      output_.erase(0, newline == std::string::npos ? newline : newline + 1);
      return line;
    }
    if (output_.size() > kMostLineBytes) throw Error("{}: a line of its output has no end", name_);
    if (!socket_.open()) return std::nullopt;
    const double remaining = seconds - timer.seconds();
    if (remaining <= 0) throw TimeOut(fmt::format("{}: no answer within {} s", name_, seconds));
    receive(std::min(remaining, kLongestPoll));
  }
}

std::string Process::wait(double seconds) {
  const WallTimer timer;
  while (!reap(false)) {
    const double remaining = seconds - timer.seconds();
    if (remaining <= 0) throw TimeOut(fmt::format("{}: did not end within {} s", name_, seconds));
    receive(std::min(remaining, kLongestPoll));
  }
  if (!WIFSIGNALED(status_)) return fmt::format("exit code {}", WEXITSTATUS(status_));
  const char* meaning = ::sigdescr_np(WTERMSIG(status_));
  return fmt::format("signal {} ({})", WTERMSIG(status_), meaning != nullptr ? meaning : "unknown");
}

std::string Process::lastLines() const {
  constexpr std::size_t kMostBytes = 4096;
  constexpr std::size_t kMostLines = 12;
  std::string text(kMostBytes, '\0');
  const int file = errors_.number;
  const off_t begin = std::max<off_t>(0, ::lseek(file, 0, SEEK_END) - off_t{kMostBytes});
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(0, ::pread(file, text.data(), kMostBytes, begin))));
  std::string_view rest = text;
  if (begin > 0) takeLine(rest);  // skips the end of a line
  std::vector<std::string_view> lines;
  while (!rest.empty()) {
    if (const std::string_view line = takeLine(rest); !line.empty()) lines.push_back(line);
  }
  lines.erase(lines.begin(), lines.end() - static_cast<std::ptrdiff_t>(std::min(kMostLines, lines.size())));
  return fmt::format("{}", fmt::join(lines, "\n"));
}

}  // namespace scanmill
