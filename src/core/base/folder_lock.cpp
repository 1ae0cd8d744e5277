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

namespace scanmill {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
  throw Error(fmt::format("{}: {}: {}", file.string(), what, std::strerror(errno)));
}

std::string hostName() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "this host";
  return name.data();
}

// What a lock file says: "process 4711 on node3 since 2026-01-31 12:00:00 UTC".
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

// By what the file says alone: whether a process that may still run holds it.
bool mayBeHeld(const std::string& words) {
  const std::string process = "process ";
  if (!words.starts_with(process)) return false;
  const auto pid = static_cast<pid_t>(std::strtol(words.c_str() + process.size(), nullptr, 10));
  if (words.find(" on " + hostName() + " since ") == std::string::npos) return true;
  return pid > 0 && pid != ::getpid() && (::kill(pid, 0) == 0 || errno == EPERM);
}

bool isStillThere(int descriptor, const std::filesystem::path& file) {
  struct stat own {};
  struct stat named {};
  return ::fstat(descriptor, &own) == 0 && ::stat(file.c_str(), &named) == 0 && own.st_ino == named.st_ino &&
         own.st_dev == named.st_dev;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind) {
  std::string holder;
  if (take(file, kind, holder)) return;
  throw InputError({folder.string()},
                   fmt::format("is being written by {}: wait for it, or choose another folder (where that process "
                               "is gone for certain, remove {})",
                               holder, file.string()));
}

std::unique_ptr<FolderLock> FolderLock::tryTake(const std::filesystem::path& file, LockKind kind, std::string& holder) {
  std::unique_ptr<FolderLock> lock(new FolderLock);
  if (!lock->take(file, kind, holder)) return nullptr;
  return lock;
}

bool FolderLock::take(const std::filesystem::path& file, LockKind kind, std::string& holder) {
  file_ = file;
  kind_ = kind;
  const auto refuse = [&](const std::string& words) {
    release();
    holder = words.empty() ? "another process" : words;
    return false;
  };
  while (true) {
    constexpr int kMode = 0644;
    descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kMode);
    if (descriptor_ < 0) fail(file, "cannot be made");
    locked_ = ::flock(descriptor_, (kind == LockKind::Alone ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0;
    if (!locked_) {
      if (errno == EWOULDBLOCK) return refuse(readWords(descriptor_));
      if (errno == EINTR) {
        release();
        continue;
      }
      if (const std::string words = readWords(descriptor_); mayBeHeld(words)) return refuse(words);
    }
    if (isStillThere(descriptor_, file)) break;
    release();  // its holder has just removed it
  }
  if (kind == LockKind::Shared && !locked_) return true;  // words would keep others from sharing
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
    fail(file, "cannot be written");
  }
  return true;
}

bool FolderLock::makeAlone() {
  if (kind_ == LockKind::Alone) return true;
  // The shared lock goes first, which network file systems would keep where they cannot give the other. Meanwhile
  // another process may take the lock, and may remove the file with it.
  if (!locked_ || ::flock(descriptor_, LOCK_UN) != 0 || ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 ||
      !isStillThere(descriptor_, file_)) {
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
  if (isStillThere(descriptor_, file_)) ::unlink(file_.c_str());
  release();
}

}  // namespace scanmill
