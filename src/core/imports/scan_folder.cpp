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

// Returns the entries of a folder for which `wanted` returns true, sorted by name; none if the folder does not exist.
template <class Wanted>
std::vector<fs::path> entriesIn(const fs::path& folder, const Wanted& wanted) {
  std::vector<fs::path> entries;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    if (wanted(entry)) entries.push_back(entry.path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

// True for the first file of each folder for which the function is called.
bool isFirstOfItsFolder(const fs::path& file) {
  static std::mutex mutex;
  static std::set<fs::path> folders;
  const std::scoped_lock lock(mutex);
  return folders.insert(file.parent_path()).second;
}

}  // namespace

std::vector<fs::path> filesIn(const fs::path& folder, bool (*wanted)(const fs::path&)) {
  std::error_code failure;
  return entriesIn(folder, [&](const auto& entry) { return entry.is_regular_file(failure) && wanted(entry.path()); });
}

std::vector<fs::path> foldersIn(const fs::path& folder) {
  std::error_code failure;
  return entriesIn(folder, [&](const auto& entry) { return entry.is_directory(failure); });
}

std::optional<ScanFolder> readPlainFolder(const fs::path& folder) {
  ScanFolder found{"files", "", {}, {}};
  const auto add = [&](const fs::path& from, const std::string& before) {
    for (const fs::path& file : filesIn(from, [](const fs::path& f) { return isScan(f); })) {
      // CSV files in a subfolder may be the tables of a report and not scans, so they are skipped.
      if (!before.empty() && file.extension() == ".csv") continue;
      found.scans.push_back({before + file.filename().string(), file, {}});
    }
  };
  add(folder, "");
  if (found.scans.empty()) {
    for (const fs::path& below : foldersIn(folder)) add(below, below.filename().string() + "-");
  }
  if (found.scans.empty()) return {};
  return found;
}

std::optional<ScanFolder> scanFolderIn(const fs::path& folder) {
  // More specific layouts are tried first.
  for (const auto read : {readNuScenesFolder, readKittiFolder, readPlainFolder}) {
    if (auto found = read(folder)) return found;
  }
  return {};
}

Scan readFolderScan(const FolderScan& scan) {
  Cloud cloud = readCloud(scan.points);
  if (!cloud.leftOut.empty() && isFirstOfItsFolder(scan.points)) cloud.leftOut.warn(scan.points.string());
  Scan read = std::move(cloud.scan);
  if (!scan.lidarseg.empty()) addLidarsegLabels(readFile(scan.lidarseg), scan.lidarseg.string(), read);
  if (!scan.panoptic.empty()) addPanopticLabels(readFile(scan.panoptic), scan.panoptic.string(), read);
  return read;
}

}  // namespace scanmill
