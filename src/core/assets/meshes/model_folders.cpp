#include "assets/meshes/model_folders.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "assets/meshes/references.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;

constexpr int kMostAbove = 8;  // largest number of folders to search, from the file's folder upwards
constexpr const char* kVariables[] = {"SDF_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH",
                                      "GAZEBO_MODEL_PATH", "ROS_PACKAGE_PATH"};

bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::vector<fs::path> modelFolders(const fs::path& file) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  fs::path above = fs::absolute(file, ignored).lexically_normal().parent_path();
  for (int i = 0; i < kMostAbove; ++i) {
    folders.push_back(above);
    folders.push_back(above / "models");
    if (above == above.parent_path()) break;
    above = above.parent_path();
  }
  for (const char* variable : kVariables) {
    const char* const value = std::getenv(variable);
    const std::string list = value == nullptr ? "" : value;
    for (std::size_t at = 0; at < list.size();) {
      const std::size_t end = std::min(list.find(':', at), list.size());
      if (end > at) folders.emplace_back(list.substr(at, end - at));
      at = end + 1;
    }
  }
  return folders;
}

}  // namespace

std::optional<fs::path> findInModelFolders(const fs::path& file, const std::string& name) {
  for (const fs::path& folder : modelFolders(file)) {
    for (const std::string& spelling : {name, decodeUri(name)}) {
      // If a file inside of a model's folder names that model, the model is found from the folder above.
      if (!spelling.empty() && isThere(folder / spelling)) return folder / spelling;
    }
  }
  return std::nullopt;
}

std::string modelFolderVariables() {
  return fmt::format("{}", fmt::join(kVariables, ", "));
}

}  // namespace scanmill
