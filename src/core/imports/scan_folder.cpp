#include "imports/scan_folder.h"

#include <algorithm>

#include "base/file.h"
#include "formats/cloud_file.h"
#include "formats/point_records.h"

namespace scanmill {

namespace fs = std::filesystem;

std::vector<fs::path> filesIn(const fs::path& folder, bool (*wanted)(const fs::path&)) {
  std::vector<fs::path> files;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    if (entry.is_regular_file(failure) && wanted(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> foldersIn(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    if (entry.is_directory(failure)) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
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
  Scan read = readCloud(scan.points).scan;
  if (!scan.lidarseg.empty()) addLidarsegLabels(readFile(scan.lidarseg), scan.lidarseg.string(), read);
  return read;
}

}  // namespace scanmill
