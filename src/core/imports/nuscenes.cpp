// Reads nuScenes (Caesar et al., CVPR 2020) with the labels of nuScenes-lidarseg and Panoptic nuScenes, as its devkit
// reads them:
//
//   v1.0-mini/sample_data.json, sample.json, scene.json, lidarseg.json, panoptic.json
//   samples/LIDAR_TOP/*.pcd.bin      the key frames, which alone have labels
//   lidarseg/v1.0-mini/*_lidarseg.bin
//   panoptic/v1.0-mini/*_panoptic.npz
//
// The given folder may be the root or the folder of the tables.

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "config/resources.h"
#include "imports/scan_folder.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::json;

constexpr std::string_view kScanTable = "sample_data.json";  // table of scans and images

// Calls readRow(row) for each row of a table. Each row is freed after the call, because a table of the complete dataset
// has millions of rows.
void readTable(const fs::path& file, const std::function<void(const Json&)>& readRow) {
  try {
    // The parser keeps no row for which this callback returns false.
    const Json table = Json::parse(readFile(file), [&](int depth, Json::parse_event_t event, Json& row) {
      if (event != Json::parse_event_t::object_end || depth != 1) return true;
      readRow(row);
      return false;
    });
    if (!table.is_array() || !table.empty()) {
      throw InputError({file.string()}, "is not a table of nuScenes: it must be a list of objects");
    }
  } catch (const Json::exception& e) {
    throw InputError({file.string()}, "is not a table of nuScenes: " + reasonOf(e));
  }
}

// Returns the folder of the tables, inside of `folder` or `folder` itself; empty if there is none. If `folder`
// contains several versions, returns the first by name.
fs::path tablesIn(const fs::path& folder) {
  if (pathExists(folder / kScanTable)) return folder;
  for (const fs::path& version : foldersIn(folder)) {
    if (version.filename().string().starts_with("v1.0-") && pathExists(version / kScanTable)) return version;
  }
  return {};
}

}  // namespace

std::optional<ScanFolder> readNuScenesFolder(const fs::path& folder) {
  const fs::path tablesAsGiven = tablesIn(folder);
  if (tablesAsGiven.empty()) return {};
  const fs::path tables = fs::absolute(tablesAsGiven).lexically_normal();
  const fs::path root = (tables.has_filename() ? tables : tables.parent_path()).parent_path();
  // columnOf() returns a map from a table's column `key` to its column `value`; empty if an optional table is missing.
  enum class Table { Required, Optional };
  using Texts = std::map<std::string, std::string>;
  const auto columnOf = [&](const char* table, const char* value, const char* key, Table need) {
    Texts values;
    if (need == Table::Optional && !pathExists(tables / table)) return values;
    readTable(tables / table,
              [&](const Json& row) { values[row.at(key).get<std::string>()] = row.at(value).get<std::string>(); });
    return values;
  };
  Texts sceneNames = columnOf("scene.json", "name", "token", Table::Required);
  Texts sceneTokens = columnOf("sample.json", "scene_token", "token", Table::Required);  // tokens of scenes, by sample
  // Names of the label files, by the token of the scan's row in sample_data.
  Texts lidarseg = columnOf("lidarseg.json", "filename", "sample_data_token", Table::Optional);
  Texts panoptic = columnOf("panoptic.json", "filename", "sample_data_token", Table::Optional);
  const auto pathOf = [&](const Texts& labels, const std::string& token) {
    const auto file = labels.find(token);
    return file == labels.end() ? fs::path() : root / file->second;
  };
  ScanFolder nuScenes{.layout = "nuscenes", .sensor = "LIDAR_TOP", .heading = kPi / 2};
  std::size_t missingScans = 0;
  readTable(tables / kScanTable, [&](const Json& row) {
    if (!row.value("is_key_frame", false) || !row.value("filename", "").ends_with(".pcd.bin")) return;
    const fs::path points = root / row.at("filename").get<std::string>();
    const std::string sample = row.at("sample_token").get<std::string>();
    const std::string token = row.at("token").get<std::string>();
    if (!pathExists(points)) {
      ++missingScans;
      return;
    }
    const std::uint64_t time = row.at("timestamp").get<std::uint64_t>();  // microseconds
    nuScenes.scans.push_back({.key = sceneNames[sceneTokens[sample]] + "-" + std::to_string(time),
                              .points = points,
                              .lidarseg = pathOf(lidarseg, token),
                              .panoptic = pathOf(panoptic, token)});
  });
  if (nuScenes.scans.empty()) {
    throw InputError({root.string()}, missingScans == 0
                                          ? "has tables of nuScenes, but they list no scan of a lidar"
                                          : "has tables of nuScenes, but the scans that they list are missing");
  }
  std::ranges::sort(nuScenes.scans, {}, &FolderScan::key);
  if (!lidarseg.empty() || !panoptic.empty()) nuScenes.ontology = readOntology(namedResource("nuscenes", "labels"));
  return nuScenes;
}

}  // namespace scanmill
