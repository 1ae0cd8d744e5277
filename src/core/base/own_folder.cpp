#include "base/own_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace scanmill {

namespace {

namespace fs = std::filesystem;

// Opens the folder `below`, step by step from `folder`. If `isNew` is given, creates missing folders, and sets `isNew`
// to true if the last folder is new. `file` and `what` begin the Error's message: "a.txt: cannot be written".
Descriptor openFolder(const fs::path& folder, const fs::path& below, const fs::path& file, const char* what,
                      bool* isNew = nullptr) {
  constexpr int kFlags = O_PATH | O_DIRECTORY | O_CLOEXEC;
  constexpr mode_t kMode = 0777;
  Descriptor parent(::open(folder.empty() ? "." : folder.c_str(), kFlags));
  if (!parent.open()) failBySystem(file, what);
  fs::path path = folder;
  for (const fs::path& step : below.lexically_relative(folder)) {
    if (step == "." || step.empty()) continue;
    path /= step;
    if (isNew != nullptr) {
      *isNew = ::mkdirat(parent.number, step.c_str(), kMode) == 0;
      if (!*isNew && errno != EEXIST) failBySystem(file, what);
    }
    Descriptor child(::openat(parent.number, step.c_str(), kFlags | O_NOFOLLOW));
    if (!child.open() && (errno == ELOOP || errno == ENOTDIR)) {
      throw ForeignFile({path.string()}, "is a link or a file, where this program has a folder: remove it");
    }
    if (!child.open()) failBySystem(file, what);
    parent = std::move(child);
  }
  return parent;
}

}  // namespace

void failBySystem(const fs::path& path, std::string_view what) {
  throw Error("{}: {}: {}", path.string(), what, std::strerror(errno));
}

bool isWithin(const fs::path& path, const fs::path& folder) {
  const auto resolved = [](const fs::path& given) {
    std::error_code failure;
    const fs::path canonical = fs::weakly_canonical(fs::absolute(given), failure);
    if (failure) throw Error("{}: cannot be resolved: {}", given.string(), failure.message());
    return canonical.has_filename() ? canonical : canonical.parent_path();
  };
  const fs::path inner = resolved(path);
  const fs::path outer = resolved(folder);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

Descriptor openFolderOf(const fs::path& folder, const fs::path& file, const char* what) {
  return openFolder(folder, file.parent_path(), file, what);
}

bool makeFolders(const fs::path& folder, const fs::path& below) {
  bool isNew = false;
  static_cast<void>(openFolder(folder, below, below, "cannot be created", &isNew));
  return isNew;
}

void moveFile(const fs::path& folder, const fs::path& from, const fs::path& to) {
  const Descriptor fromFolder = openFolderOf(folder, from, "cannot be moved");
  bool isNew = false;
  const Descriptor toFolder = openFolder(folder, to.parent_path(), from, "cannot be moved", &isNew);
  if (::renameat(fromFolder.number, from.filename().c_str(), toFolder.number, to.filename().c_str()) == 0) return;
  failBySystem(from, "cannot be moved to " + to.string());
}

void removeFile(const fs::path& folder, const fs::path& file) {
  std::error_code unreadable;
  if (!fs::exists(fs::symlink_status(file, unreadable))) return;
  const Descriptor opened = openFolderOf(folder, file, "cannot be removed");
  if (::unlinkat(opened.number, file.filename().c_str(), 0) != 0 && errno != ENOENT)
    failBySystem(file, "cannot be removed");
}

}  // namespace scanmill
