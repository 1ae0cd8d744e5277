#include "assets/asset_files.h"

#include <algorithm>
#include <set>
#include <string>
#include <system_error>

#include "config/text.h"

namespace scanmill {

std::vector<std::filesystem::path> assetsIn(const std::filesystem::path& folder) {
  static const std::set<std::string> kKinds{".gltf", ".glb", ".las",  ".pcd",   ".tif",  ".obj",
                                            ".ply",  ".stl", ".dae",  ".fbx",   ".ac",   ".acc",
                                            ".3ds",  ".sdf", ".urdf", ".world", ".b3dm", ".blend"};
  std::error_code error;
  const auto modelIn = [&](const std::filesystem::path& path) {
    const std::filesystem::path model = path / "model.sdf";
    return std::filesystem::is_regular_file(model, error) ? model : std::filesystem::path();
  };
  if (const auto model = modelIn(folder); !model.empty()) return {model};
  std::vector<std::filesystem::path> found;
  for (auto at = std::filesystem::recursive_directory_iterator(folder, error); at != end(at); at.increment(error)) {
    const std::filesystem::directory_entry& entry = *at;
    if (const auto model = modelIn(entry.path()); !model.empty()) {
      found.push_back(model);
      at.disable_recursion_pending();
    } else if (kKinds.contains(lowerExtension(entry.path())) && entry.is_regular_file(error)) {
      found.push_back(entry.path());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace scanmill
