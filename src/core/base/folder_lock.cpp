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
#include <ctime>

#include "base/error.h"
#include "base/file.h"
#include "base/process.h"

namespace scanmill {
namespace {

// Returns the text of a lock file: "process 4711 on node3 since 2026-01-31 12:00:00 UTC".
std::string ownLockText() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("process {} on {} since {:%Y-%m-%d %H:%M:%S} UTC\n", ::getpid(), hostName(), fmt::gmtime(now));
}

// Returns the first line of a lock file.
std::string readLockText(int descriptor) {
  std::array<char, 512> bytes{};
  const ssize_t size = ::pread(descriptor, bytes.data(), bytes.size(), 0);
  std::string text(bytes.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  return text.substr(0, text.find('\n'));
}

// True if the process that the text of a lock file names may still run. A process on another host counts as running.
bool mayBeHeld(const std::string& text) {
  const std::string process = "process ";
  if (!text.starts_with(process)) return false;
  const auto pid = static_cast<pid_t>(std::strtol(text.c_str() + process.size(), nullptr, 10));
  if (text.find(" on " + hostName() + " since ") == std::string::npos) return true;
  return pid > 0 && pid != ::getpid() && (::kill(pid, 0) == 0 || errno == EPERM);
}

[[noreturn]] void refuseForeign(const std::filesystem::path& file, const char* what) {
  throw ForeignFile({file.string()}, fmt::format("is {}, which this program does not make: remove it", what));
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind) {
  std::string holder;
  if (take(folder, file, kind, holder)) return;
  throw InputError({folder.string()},
                   "is being written by {}: wait for it, or choose another folder (where that process "
                   "is gone for certain, remove {})",
                   holder, file.string());
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
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor_.number, &opened) == 0 && ::lstat(file_.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
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

// Opens the lock file, and creates it if it is missing.
void FolderLock::open() {
  constexpr mode_t kMode = 0644;
  // O_NONBLOCK: if the file is a named pipe, the call does not wait for another process; the pipe is refused below.
  constexpr int kFlags = O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  const Descriptor parent = openFolderOf(folder_, file_, "cannot be made");
  descriptor_ = Descriptor(::openat(parent.number, file_.filename().c_str(), kFlags, kMode));
  struct stat status {};
  if (!descriptor_.open() || ::fstat(descriptor_.number, &status) != 0) {
    const int failure = errno;
    descriptor_.close();
    if (failure == ELOOP) refuseForeign(file_, "a link");
    if (failure == EISDIR) refuseForeign(file_, "a folder");
    errno = failure;
    failBySystem(file_, "cannot be made");
  }
  if (S_ISREG(status.st_mode) && status.st_nlink <= 1) return;
  descriptor_.close();
  refuseForeign(file_, S_ISREG(status.st_mode) ? "a file that has another name, too" : "not a file");
}

bool FolderLock::take(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind,
                      std::string& holder) {
  folder_ = folder;
  file_ = file;
  kind_ = kind;
  const auto refuse = [&](const std::string& text) {
    descriptor_.close();
    holder = text.empty() ? "another process" : text;
    return false;
  };
  for (open();; open()) {
    locked_ = ::flock(descriptor_.number, (kind == LockKind::Alone ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0;
    const int failure = locked_ ? 0 : errno;
    if (failure == EWOULDBLOCK) return refuse(readLockText(descriptor_.number));
    if (failure != 0 && failure != EINTR) {  // no locks on this file system: the file's text says who holds it
      if (const std::string text = readLockText(descriptor_.number); mayBeHeld(text)) return refuse(text);
    }
    if (failure != EINTR && isStillThere()) break;  // not there: the process that held the lock has just removed it
    descriptor_.close();
  }
  // A shared lock without flock() writes no text, because another process would take the lock for an exclusive one.
  if (kind == LockKind::Alone || locked_) writeLockText();
  return true;
}

// Replaces the text of the lock file by ownLockText().
void FolderLock::writeLockText() {
  const std::string text = ownLockText();
  ssize_t n = ::ftruncate(descriptor_.number, 0);
  for (std::size_t done = 0; n >= 0 && done < text.size(); done += static_cast<std::size_t>(std::max<ssize_t>(n, 0))) {
    n = ::pwrite(descriptor_.number, text.data() + done, text.size() - done, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) n = 0;
  }
  if (n >= 0) return;
  const int failure = errno;
  descriptor_.close();
  errno = failure;
  failBySystem(file_, "cannot be written");
}

bool FolderLock::makeAlone() {
  if (kind_ == LockKind::Alone) return true;
  // Releases the shared lock first, because a network file system that cannot grant the exclusive lock would keep the
  // shared one. Between the two calls another process may take the lock, and may remove the file when it ends.
  if (!locked_ || ::flock(descriptor_.number, LOCK_UN) != 0 || ::flock(descriptor_.number, LOCK_EX | LOCK_NB) != 0 ||
      !isStillThere()) {
    descriptor_.close();
    return false;
  }
  kind_ = LockKind::Alone;
  return true;
}

FolderLock::~FolderLock() {
  if (descriptor_.open() && makeAlone()) remove();
}

}  // namespace scanmill
