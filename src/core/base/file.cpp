#include "base/file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <random>
#include <vector>

#include "base/error.h"
#include "base/input_budget.h"
#include "base/memory.h"
#include "base/own_folder.h"
#include "base/process.h"
#include "base/short_text.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostBlockBytes = std::size_t{1} << 20;

std::string reason() {
  return std::strerror(errno);
}

// Returns the ending of a temporary name. The random part differs even if two containers have processes of the same id.
std::string temporarySuffix() {
  std::string host = hostName().substr(0, 32);
  std::ranges::replace_if(
      host, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return fmt::format(".partial-{}-{:08x}-{}", ::getpid(), std::random_device{}(), host);
}

}  // namespace

void Descriptor::close() {
  if (open()) ::close(number);
  number = -1;
}

void readBlocks(const std::filesystem::path& path, const std::function<void(std::string_view)>& visit) {
  // O_NONBLOCK: if the file is a named pipe, the call does not wait for a writer; the pipe is refused below.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number < 0) throw InputError({path.string()}, "cannot be read: " + reason());
  struct stat status {};
  if (::fstat(file.number, &status) != 0) throw InputError({path.string()}, "cannot be read: " + reason());
  if (!S_ISREG(status.st_mode)) throw InputError({path.string()}, "is not a file");
  std::vector<char> block(std::clamp<std::size_t>(static_cast<std::size_t>(status.st_size), 1, kMostBlockBytes));
  for (;;) {
    const ssize_t n = ::read(file.number, block.data(), block.size());
    if (n == 0) return;
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw InputError({path.string()}, "cannot be read: " + reason());
    visit({block.data(), static_cast<std::size_t>(n)});
  }
}

std::string readFile(const std::filesystem::path& path) {
  chargeFile(path);
  std::string bytes;
  std::error_code unknown;
  if (const std::uintmax_t size = std::filesystem::file_size(path, unknown); !unknown) {
    if (size > memoryLimitBytes()) {
      throw InputError({path.string()},
                       "has {}, but only {} of memory are allowed (by --memory-limit, the machine or its "
                       "container)",
                       shortBytes(size), shortBytes(memoryLimitBytes()));
    }
    bytes.reserve(size);
  }
  readBlocks(path, [&](std::string_view block) { bytes += block; });
  recordFile(path, bytes);
  return bytes;
}

AtomicFile::AtomicFile(const std::filesystem::path& folder, std::filesystem::path path) : path_(std::move(path)) {
  // A rename would replace a device such as /dev/null, and fail onto a folder only after all the work: refuse both.
  struct stat status {};
  if (::stat(path_.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
    throw Error("{}: cannot be written: it exists and is not a file", path_.string());
  }
  folder_ = openFolderOf(folder, path_, "cannot be written");
  do {
    temporary_ = path_.filename().string() + temporarySuffix();
    constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
    constexpr mode_t kMode = 0644;
    file_ = Descriptor(::openat(folder_.number, temporary_.c_str(), kFlags, kMode));
  } while (!file_.open() && errno == EEXIST);
  if (!file_.open()) failBySystem(path_, "cannot be written");
}

AtomicFile::~AtomicFile() {
  if (file_.open()) ::unlinkat(folder_.number, temporary_.c_str(), 0);
}

void AtomicFile::write(std::string_view bytes) {
  flushed_ = false;
  while (!bytes.empty()) {
    const ssize_t n = ::write(file_.number, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) failBySystem(path_, "cannot be written");
    bytes.remove_prefix(static_cast<std::size_t>(n));
    size_ += static_cast<std::size_t>(n);
  }
}

void AtomicFile::rewriteStart(std::string_view bytes) {
  flushed_ = false;
  if (::pwrite(file_.number, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    failBySystem(path_, "cannot be written");
  }
}

void AtomicFile::flush() {
  if (!flushed_ && ::fsync(file_.number) != 0) failBySystem(path_, "cannot be written");
  flushed_ = true;
}

void AtomicFile::commit() {
  flush();
  if (::renameat(folder_.number, temporary_.c_str(), folder_.number, path_.filename().c_str()) != 0) {
    failBySystem(path_, "cannot be written");
  }
  file_.close();
  syncFolder(path_.parent_path());
}

void syncFolder(const std::filesystem::path& folder) {
  const Descriptor opened(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.open() && ::fsync(opened.number) == 0) return;
  // Some file systems cannot flush folders, and a folder may be writable without being readable.
  if (errno != EINVAL && errno != ENOTSUP && errno != EACCES) failBySystem(folder, "cannot be flushed");
}

void writeFile(const std::filesystem::path& path, std::string_view bytes) {
  std::error_code ignored;  // writing the file then fails with the reason
  std::filesystem::create_directories(path.parent_path(), ignored);
  writeFile(path.parent_path(), path, bytes);
}

void writeFile(const std::filesystem::path& folder, const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(folder, path);
  file.write(bytes);
  file.commit();
}

ScratchFolder::ScratchFolder() {
  std::error_code none;
  std::filesystem::path parent = std::filesystem::temp_directory_path(none);
  if (none) parent = "/tmp";
  std::string name = (parent / "scanmill-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw Error("{}: no temporary folder: {}; set TMPDIR to a folder with room", parent.string(), std::strerror(errno));
  }
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace scanmill
