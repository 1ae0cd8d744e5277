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

constexpr std::string_view kRows = "sample_data.json";

// Calls take(row) for each row of a table. Each row is freed after the call, because a table of the complete dataset
// has millions of rows.
void readTable(const fs::path& file, const std::function<void(const Json&)>& take) {
  try {
    const Json rest = Json::parse(readFile(file), [&](int depth, Json::parse_event_t event, Json& row) {
      if (event != Json::parse_event_t::object_end || depth != 1) return true;
      take(row);
      return false;
    });
    if (!rest.is_array() || !rest.empty()) {
      throw InputError({file.string()}, "is not a table of nuScenes: it must be a list of objects");
    }
  } catch (const Json::exception& e) {
    throw InputError({file.string()}, "is not a table of nuScenes: " + reasonOf(e));
  }
}

// Returns the folder of the tables, inside of `folder` or `folder` itself; empty if there is none. If `folder`
// contains several versions, returns the first by name.
fs::path tablesIn(const fs::path& folder) {
  if (pathExists(folder / kRows)) return folder;
  std::vector<fs::path> versions;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    if (entry.path().filename().string().starts_with("v1.0-") && pathExists(entry.path() / kRows)) {
      versions.push_back(entry.path());
    }
  }
  std::sort(versions.begin(), versions.end());
  return versions.empty() ? fs::path() : versions.front();
}

}  // namespace

std::optional<ScanFolder> readNuScenesFolder(const fs::path& folder) {
  const fs::path given = tablesIn(folder);
  if (given.empty()) return {};
  const fs::path tables = fs::absolute(given).lexically_normal();
  const fs::path root = (tables.has_filename() ? tables : tables.parent_path()).parent_path();
  std::map<std::string, std::string> sceneOf;  // token of the scene, by token of a sample
  std::map<std::string, std::string> nameOf;   // name of a scene, by its token
  readTable(tables / "scene.json",
            [&](const Json& row) { nameOf[row.at("token").get<std::string>()] = row.at("name").get<std::string>(); });
  readTable(tables / "sample.json", [&](const Json& row) {
    sceneOf[row.at("token").get<std::string>()] = row.at("scene_token").get<std::string>();
  });
  const auto labelFiles = [&](const char* name) {
    std::map<std::string, fs::path> files;  // by token of sample_data
    if (!pathExists(tables / name)) return files;
    readTable(tables / name, [&](const Json& row) {
      files[row.at("sample_data_token").get<std::string>()] = root / row.at("filename").get<std::string>();
    });
    return files;
  };
  std::map<std::string, fs::path> lidarseg = labelFiles("lidarseg.json");
  std::map<std::string, fs::path> panoptic = labelFiles("panoptic.json");
  const bool labelled = !lidarseg.empty() || !panoptic.empty();
  ScanFolder found{"nuscenes", "LIDAR_TOP", {}, {}};
  std::size_t absent = 0;
  readTable(tables / kRows, [&](const Json& row) {
    if (!row.value("is_key_frame", false) || !row.value("filename", "").ends_with(".pcd.bin")) return;
    const fs::path points = root / row.at("filename").get<std::string>();
    const std::string sample = row.at("sample_token").get<std::string>();
    const std::string token = row.at("token").get<std::string>();
    if (!pathExists(points)) {
      ++absent;
      return;
    }
    const std::uint64_t time = row.at("timestamp").get<std::uint64_t>();  // microseconds
    found.scans.push_back(
        {nameOf[sceneOf[sample]] + "-" + std::to_string(time), points, lidarseg[token], panoptic[token]});
  });
  if (found.scans.empty()) {
    throw InputError({root.string()}, absent == 0 ? "has tables of nuScenes, but they list no scan of a lidar"
                                                  : "has tables of nuScenes, but the scans that they list are missing");
  }
  std::sort(found.scans.begin(), found.scans.end(),
            [](const FolderScan& a, const FolderScan& b) { return a.key < b.key; });
  if (labelled) found.ontology = readOntology(namedResource("nuscenes", "labels"));
  return found;
}

}  // namespace scanmill
