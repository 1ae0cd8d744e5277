#include "imports/scan_folder.h"

#include <algorithm>
#include <mutex>
#include <set>
#include <utility>

#include "base/file.h"
#include "formats/cloud_file.h"
#include "formats/readers.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Returns the entries of a folder that `accepts` accepts, sorted by name; none if the folder does not exist.
template <class Accepts>
std::vector<fs::path> entriesIn(const fs::path& folder, const Accepts& accepts) {
  std::vector<fs::path> entries;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    if (accepts(entry)) entries.push_back(entry.path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

// True if no earlier call was for a file in the same folder.
bool isFirstOfItsFolder(const fs::path& file) {
  static std::mutex mutex;
  static std::set<fs::path> folders;
  const std::scoped_lock lock(mutex);
  return folders.insert(file.parent_path()).second;
}

}  // namespace

std::vector<fs::path> filesIn(const fs::path& folder, bool (*accepts)(const fs::path&)) {
  std::error_code failure;
  return entriesIn(folder, [&](const auto& entry) { return entry.is_regular_file(failure) && accepts(entry.path()); });
}

std::vector<fs::path> foldersIn(const fs::path& folder) {
  std::error_code failure;
  return entriesIn(folder, [&](const auto& entry) { return entry.is_directory(failure); });
}

std::optional<ScanFolder> readPlainFolder(const fs::path& folder) {
  ScanFolder plain{.layout = "files", .sensor = ""};
  const auto addScansIn = [&](const fs::path& scans, const std::string& keyPrefix) {
    for (const fs::path& file : filesIn(scans, [](const fs::path& f) { return isScan(f); })) {
      // CSV files in a subfolder may be the tables of a report and not scans, so they are skipped.
      if (!keyPrefix.empty() && file.extension() == ".csv") continue;
      plain.scans.push_back({.key = keyPrefix + file.filename().string(), .points = file});
    }
  };
  addScansIn(folder, "");
  if (plain.scans.empty()) {
    for (const fs::path& subfolder : foldersIn(folder)) addScansIn(subfolder, subfolder.filename().string() + "-");
  }
  return plain.scans.empty() ? std::nullopt : std::optional(std::move(plain));
}

std::optional<ScanFolder> scanFolderIn(const fs::path& folder) {
  // More specific layouts are tried first.
  for (const auto readLayout : {readNuScenesFolder, readKittiFolder, readPlainFolder}) {
    if (auto scans = readLayout(folder)) return scans;
  }
  return {};
}

Scan readFolderScan(const FolderScan& files) {
  Cloud cloud = readCloud(files.points);
  if (!cloud.leftOut.empty() && isFirstOfItsFolder(files.points)) cloud.leftOut.warn(files.points.string());
  if (!files.lidarseg.empty()) addLidarsegLabels(readFile(files.lidarseg), files.lidarseg.string(), cloud.scan);
  if (!files.panoptic.empty()) addPanopticLabels(readFile(files.panoptic), files.panoptic.string(), cloud.scan);
  return std::move(cloud.scan);
}

}  // namespace scanmill
