#include "assets/asset_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <system_error>

#include "base/error.h"
#include "config/text.h"

namespace scanmill {

std::vector<std::filesystem::path> assetsIn(const std::filesystem::path& folder) {
  static const std::set<std::string> kKinds{".gltf", ".glb",  ".las",   ".pcd",  ".tif",   ".obj", ".ply",  ".stl",
                                            ".dae",  ".fbx",  ".ac",    ".acc",  ".3ds",   ".off", ".x",    ".xyz",
                                            ".sdf",  ".urdf", ".world", ".b3dm", ".blend", ".drc", ".ac3d", ".tiff"};
  static const std::set<std::string> kOtherKinds{".3mf", ".amf", ".asc", ".csv",  ".dxf", ".e57",
                                                 ".ifc", ".laz", ".lwo", ".npz",  ".osm", ".pbf",
                                                 ".pts", ".ptx", ".usd", ".usdz", ".wrl", ".x3d"};
  std::error_code error;
  const auto modelIn = [&](const std::filesystem::path& path) {
    for (const char* name : {"model.sdf", "tileset.json"}) {
      if (std::filesystem::is_regular_file(path / name, error)) return path / name;
    }
    return std::filesystem::path();
  };
  if (const auto model = modelIn(folder); !model.empty()) return {model};
  std::vector<std::filesystem::path> found;
  std::map<std::string, int> others;
  for (auto at = std::filesystem::recursive_directory_iterator(folder, error); at != end(at); at.increment(error)) {
    const std::filesystem::directory_entry& entry = *at;
    const std::string kind = lowerExtension(entry.path());
    if (const auto model = modelIn(entry.path()); !model.empty()) {
      found.push_back(model);
      at.disable_recursion_pending();
    } else if (kKinds.contains(kind) && entry.is_regular_file(error)) {
      found.push_back(entry.path());
    } else if (kOtherKinds.contains(kind) && entry.is_regular_file(error)) {
      ++others[kind];
    }
  }
  std::string told;
  for (const auto& [kind, count] : others) told += fmt::format("{}{} {}", told.empty() ? "" : ", ", count, kind);
  if (!told.empty()) {
    warn(
        fmt::format("{}: left out: {}: of a folder only files that are surely meshes, clouds or worlds are taken; some "
                    "of the others are read if you name them, or after a conversion",
                    folder.string(), told));
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace scanmill
