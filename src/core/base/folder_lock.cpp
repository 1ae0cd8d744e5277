#include "base/folder_lock.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>

#include "base/error.h"
#include "base/file.h"
#include "base/own_folder.h"
#include "base/process.h"

namespace scanmill {
namespace {

// Returns the text of a lock file: "process 4711 on node3 since 2026-01-31 12:00:00 UTC".
std::string ownWords() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("process {} on {} since {:%Y-%m-%d %H:%M:%S} UTC\n", ::getpid(), hostName(), fmt::gmtime(now));
}

std::string readWords(int descriptor) {
  std::array<char, 512> words{};
  const ssize_t size = ::pread(descriptor, words.data(), words.size(), 0);
  std::string text(words.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  return text.substr(0, text.find('\n'));
}

// True if the process that the text of a lock file names may still run. A process on another host counts as running.
bool mayBeHeld(const std::string& words) {
  const std::string process = "process ";
  if (!words.starts_with(process)) return false;
  const auto pid = static_cast<pid_t>(std::strtol(words.c_str() + process.size(), nullptr, 10));
  if (words.find(" on " + hostName() + " since ") == std::string::npos) return true;
  return pid > 0 && pid != ::getpid() && (::kill(pid, 0) == 0 || errno == EPERM);
}

bool isSame(const struct stat& a, const struct stat& b) {
  return a.st_ino == b.st_ino && a.st_dev == b.st_dev;
}

[[noreturn]] void refuseForeign(const std::filesystem::path& file, const char* what) {
  throw ForeignFile({file.string()}, fmt::format("is {}, which this program does not make: remove it", what));
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind) {
  std::string holder;
  if (take(folder, file, kind, holder)) return;
  throw InputError({folder.string()},
                   fmt::format("is being written by {}: wait for it, or choose another folder (where that process "
                               "is gone for certain, remove {})",
                               holder, file.string()));
}

std::unique_ptr<FolderLock> FolderLock::tryTake(const std::filesystem::path& folder, const std::filesystem::path& file,
                                                LockKind kind, std::string& holder) {
  std::unique_ptr<FolderLock> lock(new FolderLock);
  if (!lock->take(folder, file, kind, holder)) return nullptr;
  return lock;
}

// True if the lock file's path still leads to the file that this object has open. Opens no descriptor, since the
// process may have none left.
bool FolderLock::isStillThere() const {
  struct stat own {};
  struct stat named {};
  return ::fstat(descriptor_, &own) == 0 && ::lstat(file_.c_str(), &named) == 0 && isSame(own, named);
}

// Removes the lock file, unless its path now leads to another file or through a link.
void FolderLock::remove() const {
  if (!isStillThere()) return;
  try {
    removeFile(folder_, file_);
  } catch (const Error&) {
    // The folder has changed or vanished: the file stays.
  }
}

bool FolderLock::take(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind,
                      std::string& holder) {
  folder_ = folder;
  file_ = file;
  kind_ = kind;
  const auto refuse = [&](const std::string& words) {
    release();
    holder = words.empty() ? "another process" : words;
    return false;
  };
  while (true) {
    constexpr int kMode = 0644;
    const Descriptor place = openFolderOf(folder, file, "cannot be made");
    // O_NONBLOCK: if the file is a named pipe, the call does not wait for another process; the pipe is refused below.
    constexpr int kHow = O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    descriptor_ = ::openat(place.number, file.filename().c_str(), kHow, kMode);
    struct stat status {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
      const int reason = errno;
      release();
      if (reason == ELOOP) refuseForeign(file, "a link");
      if (reason == EISDIR) refuseForeign(file, "a folder");
      errno = reason;
      failBySystem(file, "cannot be made");
    }
    if (!S_ISREG(status.st_mode) || status.st_nlink > 1) {
      release();
      refuseForeign(file, S_ISREG(status.st_mode) ? "a file that has another name, too" : "not a file");
    }
    locked_ = ::flock(descriptor_, (kind == LockKind::Alone ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0;
    if (!locked_) {
      if (errno == EWOULDBLOCK) return refuse(readWords(descriptor_));
      if (errno == EINTR) {
        release();
        continue;
      }
      if (const std::string words = readWords(descriptor_); mayBeHeld(words)) return refuse(words);
    }
    if (isStillThere()) break;
    release();  // the process that held the lock has just removed the file
  }
  if (kind == LockKind::Shared && !locked_)
    return true;  // writes no text, because another process would take the text for that of an exclusive lock
  const std::string words = ownWords();
  ssize_t n = ::ftruncate(descriptor_, 0);
  for (std::size_t done = 0; n >= 0 && done < words.size(); done += static_cast<std::size_t>(std::max<ssize_t>(n, 0))) {
    n = ::pwrite(descriptor_, words.data() + done, words.size() - done, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) n = 0;
  }
  if (n < 0) {
    const int reason = errno;
    release();
    errno = reason;
    failBySystem(file, "cannot be written");
  }
  return true;
}

bool FolderLock::makeAlone() {
  if (kind_ == LockKind::Alone) return true;
  // Releases the shared lock first, because a network file system that cannot grant the exclusive lock would keep the
  // shared one. Between the two calls another process may take the lock, and may remove the file when it ends.
  if (!locked_ || ::flock(descriptor_, LOCK_UN) != 0 || ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 ||
      !isStillThere()) {
    release();
    return false;
  }
  kind_ = LockKind::Alone;
  return true;
}

void FolderLock::release() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0 || !makeAlone()) return;
  remove();
  release();
}

}  // namespace scanmill
