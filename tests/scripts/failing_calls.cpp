// Makes a chosen system call of a program fail, for faults_test.py:
//
//     g++ -std=c++20 -shared -fPIC -O1 -Wall -Wextra -Wconversion failing_calls.cpp -o failing_calls.so
//     LD_PRELOAD=./failing_calls.so FAULT_FOLDER=/data/out FAULT_KIND=rename FAULT_AT=3 FAULT_DO=ENOSPC
//     FAULT_REPORT=calls scanmill ...
//
// FAULT_FOLDER  calls count whose path, or that of whose descriptor, is this folder or within it; absolute, no links
// FAULT_KIND    which calls: one of kKinds below
// FAULT_AT      which of them, from 1 on, in the order in which they come; 0: none, they are counted only
// FAULT_DO      what happens: the name of an error (nothing is done, but close() closes), `short` (half is written or
//               read), `kill` or `kill-after` (SIGKILL before or after the call), `stop` (SIGSTOP before it)
// FAULT_STAY    not empty: to it and all later ones of its kind; `disk`: also to later ones that change files
// FAULT_REPORT  a file that gets, at the end, how many calls of each kind came, and which was struck first:
//               `write 12`, `struck write /path`
//
// What cannot be seen from here are the calls that libc makes itself: those of FILE (fopen, whose opening is seen, and
// fwrite, fflush, fclose), of opendir(), remove() and mkstemp(). std::ofstream opens by fopen64, but writes by write()
// and writev(). The first of them are taken at their names here.

#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

enum Kind {
  Open,
  OpenToRead,
  Read,
  Write,
  Truncate,
  Fsync,
  Rename,
  Mkdir,
  Close,
  Link,
  Unlink,
  Flock,
  Stat,
  kKindCount
};
constexpr std::array<const char*, kKindCount> kKinds{"open",   "open-to-read", "read",  "write", "truncate",
                                                     "fsync",  "rename",       "mkdir", "close", "link",
                                                     "unlink", "flock",        "stat"};

enum class Act { Pass, Fail, Short, KillAfter };

struct NamedError {
  const char* name;
  int number;
};
constexpr std::array kErrors{NamedError{"ENOSPC", ENOSPC}, NamedError{"EIO", EIO},       NamedError{"EROFS", EROFS},
                             NamedError{"EACCES", EACCES}, NamedError{"EINTR", EINTR},   NamedError{"EDQUOT", EDQUOT},
                             NamedError{"EMFILE", EMFILE}, NamedError{"ESTALE", ESTALE}, NamedError{"ENOLCK", ENOLCK},
                             NamedError{"EINVAL", EINVAL}, NamedError{"EFBIG", EFBIG},   NamedError{"EXDEV", EXDEV},
                             NamedError{"EPERM", EPERM},   NamedError{"ENOSYS", ENOSYS}};

std::string setting(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int fail(int number) {
  errno = number;
  return -1;
}

class Faults {
 public:
  Faults() {
    const std::string kind = setting("FAULT_KIND");
    for (int i = 0; i < kKindCount; ++i) {
      if (kind == kKinds[static_cast<std::size_t>(i)]) kind_ = i;
    }
    for (const NamedError& error : kErrors) {
      if (does_ == error.name) error_ = error.number;
    }
  }

  ~Faults() { report(); }

  // Whether calls of such a path are of interest.
  bool covers(const std::string& path) const {
    return !folder_.empty() && path.starts_with(folder_) &&
           (path.size() == folder_.size() || path[folder_.size()] == '/');
  }

  // Counts a call and says what becomes of it; sets errno where it fails.
  Act meet(Kind kind, const std::string& path) {
    if (!covers(path)) return Act::Pass;
    const long number = ++seen_[kind];
    const bool strikes = kind == kind_ && at_ > 0 && (number == at_ || (number > at_ && !stay_.empty()));
    const bool disk = stay_ == "disk" && struck_ && changes(kind);
    if (!strikes && !disk) return Act::Pass;
    if (!struck_.exchange(true)) std::snprintf(where_.data(), where_.size(), "%s %s", kKinds[kind], path.c_str());
    if (does_ == "kill") kill();
    if (does_ == "kill-after") return Act::KillAfter;
    if (does_ == "stop") {
      report();
      ::raise(SIGSTOP);
      return Act::Pass;
    }
    if (does_ == "short") return Act::Short;
    errno = error_;
    return Act::Fail;
  }

  void kill() {
    report();
    ::raise(SIGKILL);
  }

 private:
  static bool changes(int kind) {
    return kind != OpenToRead && kind != Read && kind != Close && kind != Flock && kind != Stat;
  }

  void report() {
    static const auto openFile = next<int(const char*, int, ...)>("open");
    static const auto writeBytes = next<ssize_t(int, const void*, std::size_t)>("write");
    if (report_.empty()) return;
    std::string text;
    for (std::size_t i = 0; i < kKindCount; ++i) text += std::string(kKinds[i]) + " " + std::to_string(seen_[i]) + "\n";
    if (struck_) text += std::string("struck ") + where_.data() + "\n";
    const int descriptor = openFile(report_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (descriptor < 0 || writeBytes(descriptor, text.data(), text.size()) < 0) std::perror(report_.c_str());
  }

  std::string folder_ = setting("FAULT_FOLDER");
  std::string does_ = setting("FAULT_DO");
  std::string stay_ = setting("FAULT_STAY");
  std::string report_ = setting("FAULT_REPORT");
  int kind_ = -1;
  long at_ = std::atol(setting("FAULT_AT").c_str());
  int error_ = EIO;
  std::array<std::atomic<long>, kKindCount> seen_{};
  std::atomic<bool> struck_ = false;
  std::array<char, PATH_MAX> where_{};
};

Faults& faults() {
  static Faults all;
  return all;
}
// Made before main() begins, and gone behind all that exit() ends of the program.
const Faults& madeEarly = faults();

std::string pathOf(int descriptor) {
  const int before = errno;
  std::array<char, PATH_MAX> path{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t size = ::readlink(link.c_str(), path.data(), path.size() - 1);
  errno = before;
  return size > 0 ? std::string(path.data(), static_cast<std::size_t>(size)) : std::string();
}

// Absolute, so that its beginning tells where it leads.
std::string whole(const char* path, int folder = AT_FDCWD) {
  if (path == nullptr) return {};
  if (path[0] == '/') return path;
  const int before = errno;
  std::string base;
  if (folder != AT_FDCWD) {
    base = pathOf(folder);
  } else {
    std::array<char, PATH_MAX> current{};
    if (::getcwd(current.data(), current.size()) != nullptr) base = current.data();
  }
  errno = before;
  return path[0] == '\0' ? base : base + "/" + path;
}

// The call, or what happens in its place. `call` is told whether it is to do half of its work.
template <class Call>
auto withFault(Kind kind, const std::string& path, Call call) -> decltype(call(false)) {
  const Act act = faults().meet(kind, path);
  if (act == Act::Fail) {
    using Result = decltype(call(false));
    if constexpr (std::is_pointer_v<Result>) {
      return nullptr;
    } else {
      return -1;
    }
  }
  const auto result = call(act == Act::Short);
  if (act == Act::KillAfter) faults().kill();
  return result;
}

std::size_t part(std::size_t size, bool half) {
  return half ? std::max<std::size_t>(size / 2, size > 0 ? 1 : 0) : size;
}

Kind kindOf(int flags) {
  return (flags & O_ACCMODE) == O_RDONLY && (flags & O_CREAT) == 0 ? OpenToRead : Open;
}

Kind kindOf(const char* mode) {
  return mode[0] == 'r' && std::strchr(mode, '+') == nullptr ? OpenToRead : Open;
}

mode_t modeOf(int flags, va_list arguments) {
  return (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

// The names of libc, which programs and libraries find here first.
extern "C" {

#define OPEN(NAME)                                                                               \
  int NAME(const char* path, int flags, ...) {                                                   \
    static const auto real = next<int(const char*, int, ...)>(#NAME);                            \
    va_list arguments;                                                                           \
    va_start(arguments, flags);                                                                  \
    const mode_t mode = modeOf(flags, arguments);                                                \
    va_end(arguments);                                                                           \
    return withFault(kindOf(flags), whole(path), [&](bool) { return real(path, flags, mode); }); \
  }
OPEN(open)
OPEN(open64)

#define OPENAT(NAME)                                                                                             \
  int NAME(int folder, const char* path, int flags, ...) {                                                       \
    static const auto real = next<int(int, const char*, int, ...)>(#NAME);                                       \
    va_list arguments;                                                                                           \
    va_start(arguments, flags);                                                                                  \
    const mode_t mode = modeOf(flags, arguments);                                                                \
    va_end(arguments);                                                                                           \
    return withFault(kindOf(flags), whole(path, folder), [&](bool) { return real(folder, path, flags, mode); }); \
  }
OPENAT(openat)
OPENAT(openat64)

#define CREAT(NAME)                                                              \
  int NAME(const char* path, mode_t mode) {                                      \
    static const auto real = next<int(const char*, mode_t)>(#NAME);              \
    return withFault(Open, whole(path), [&](bool) { return real(path, mode); }); \
  }
CREAT(creat)
CREAT(creat64)

#define FOPEN(NAME)                                                                      \
  FILE* NAME(const char* path, const char* mode) {                                       \
    static const auto real = next<FILE*(const char*, const char*)>(#NAME);               \
    return withFault(kindOf(mode), whole(path), [&](bool) { return real(path, mode); }); \
  }
FOPEN(fopen)
FOPEN(fopen64)

DIR* opendir(const char* path) {
  static const auto real = next<DIR*(const char*)>("opendir");
  return withFault(OpenToRead, whole(path), [&](bool) { return real(path); });
}

ssize_t read(int descriptor, void* bytes, std::size_t size) {
  static const auto real = next<ssize_t(int, void*, std::size_t)>("read");
  return withFault(Read, pathOf(descriptor), [&](bool half) { return real(descriptor, bytes, part(size, half)); });
}

#define PREAD(NAME)                                                                                 \
  ssize_t NAME(int descriptor, void* bytes, std::size_t size, off_t offset) {                       \
    static const auto real = next<ssize_t(int, void*, std::size_t, off_t)>(#NAME);                  \
    return withFault(Read, pathOf(descriptor),                                                      \
                     [&](bool half) { return real(descriptor, bytes, part(size, half), offset); }); \
  }
PREAD(pread)
PREAD(pread64)

ssize_t write(int descriptor, const void* bytes, std::size_t size) {
  static const auto real = next<ssize_t(int, const void*, std::size_t)>("write");
  return withFault(Write, pathOf(descriptor), [&](bool half) { return real(descriptor, bytes, part(size, half)); });
}

ssize_t writev(int descriptor, const struct iovec* pieces, int count) {
  static const auto real = next<ssize_t(int, const struct iovec*, int)>("writev");
  return withFault(Write, pathOf(descriptor),
                   [&](bool half) { return real(descriptor, pieces, half && count > 1 ? 1 : count); });
}

#define PWRITE(NAME)                                                                                \
  ssize_t NAME(int descriptor, const void* bytes, std::size_t size, off_t offset) {                 \
    static const auto real = next<ssize_t(int, const void*, std::size_t, off_t)>(#NAME);            \
    return withFault(Write, pathOf(descriptor),                                                     \
                     [&](bool half) { return real(descriptor, bytes, part(size, half), offset); }); \
  }
PWRITE(pwrite)
PWRITE(pwrite64)

#define FTRUNCATE(NAME)                                                                           \
  int NAME(int descriptor, off_t size) noexcept {                                                 \
    static const auto real = next<int(int, off_t)>(#NAME);                                        \
    return withFault(Truncate, pathOf(descriptor), [&](bool) { return real(descriptor, size); }); \
  }
FTRUNCATE(ftruncate)
FTRUNCATE(ftruncate64)

#define FSYNC(NAME)                                                                      \
  int NAME(int descriptor) {                                                             \
    static const auto real = next<int(int)>(#NAME);                                      \
    return withFault(Fsync, pathOf(descriptor), [&](bool) { return real(descriptor); }); \
  }
FSYNC(fsync)
FSYNC(fdatasync)

int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags) noexcept {
  static const auto real = next<int(int, const char*, int, const char*, unsigned)>("renameat2");
  const std::string target = whole(to, toFolder);
  return withFault(Rename, faults().covers(target) ? target : whole(from, fromFolder),
                   [&](bool) { return real(fromFolder, from, toFolder, to, flags); });
}

int renameat(int fromFolder, const char* from, int toFolder, const char* to) noexcept {
  return renameat2(fromFolder, from, toFolder, to, 0);
}

int rename(const char* from, const char* to) noexcept {
  return renameat2(AT_FDCWD, from, AT_FDCWD, to, 0);
}

int mkdir(const char* path, mode_t mode) noexcept {
  static const auto real = next<int(const char*, mode_t)>("mkdir");
  return withFault(Mkdir, whole(path), [&](bool) { return real(path, mode); });
}

int mkdirat(int folder, const char* path, mode_t mode) noexcept {
  static const auto real = next<int(int, const char*, mode_t)>("mkdirat");
  return withFault(Mkdir, whole(path, folder), [&](bool) { return real(folder, path, mode); });
}

// Linux closes a descriptor also where it reports an error of writing.
int close(int descriptor) {
  static const auto real = next<int(int)>("close");
  const Act act = faults().meet(Close, pathOf(descriptor));
  const int reported = errno;
  const int result = real(descriptor);
  if (act == Act::KillAfter) faults().kill();
  return act == Act::Fail ? fail(reported) : result;
}

int linkat(int fromFolder, const char* from, int toFolder, const char* to, int flags) noexcept {
  static const auto real = next<int(int, const char*, int, const char*, int)>("linkat");
  return withFault(Link, whole(to, toFolder), [&](bool) { return real(fromFolder, from, toFolder, to, flags); });
}

int link(const char* from, const char* to) noexcept {
  return linkat(AT_FDCWD, from, AT_FDCWD, to, 0);
}

int symlink(const char* target, const char* path) noexcept {
  static const auto real = next<int(const char*, const char*)>("symlink");
  return withFault(Link, whole(path), [&](bool) { return real(target, path); });
}

int unlinkat(int folder, const char* path, int flags) noexcept {
  static const auto real = next<int(int, const char*, int)>("unlinkat");
  return withFault(Unlink, whole(path, folder), [&](bool) { return real(folder, path, flags); });
}

#define UNLINK(NAME)                                                         \
  int NAME(const char* path) noexcept {                                      \
    static const auto real = next<int(const char*)>(#NAME);                  \
    return withFault(Unlink, whole(path), [&](bool) { return real(path); }); \
  }
UNLINK(unlink)
UNLINK(remove)
UNLINK(rmdir)

int flock(int descriptor, int operation) noexcept {
  static const auto real = next<int(int, int)>("flock");
  return withFault(Flock, pathOf(descriptor), [&](bool) { return real(descriptor, operation); });
}

#define STAT(NAME, TYPE)                                                           \
  int NAME(const char* path, TYPE* status) noexcept {                              \
    static const auto real = next<int(const char*, TYPE*)>(#NAME);                 \
    return withFault(Stat, whole(path), [&](bool) { return real(path, status); }); \
  }
STAT(stat, struct stat)
STAT(stat64, struct stat64)
STAT(lstat, struct stat)
STAT(lstat64, struct stat64)

#define FSTAT(NAME, TYPE)                                                                       \
  int NAME(int descriptor, TYPE* status) noexcept {                                             \
    static const auto real = next<int(int, TYPE*)>(#NAME);                                      \
    return withFault(Stat, pathOf(descriptor), [&](bool) { return real(descriptor, status); }); \
  }
FSTAT(fstat, struct stat)
FSTAT(fstat64, struct stat64)

#define FSTATAT(NAME, TYPE)                                                                               \
  int NAME(int folder, const char* path, TYPE* status, int flags) noexcept {                              \
    static const auto real = next<int(int, const char*, TYPE*, int)>(#NAME);                              \
    return withFault(Stat, whole(path, folder), [&](bool) { return real(folder, path, status, flags); }); \
  }
FSTATAT(fstatat, struct stat)
FSTATAT(fstatat64, struct stat64)

}  // extern "C"
