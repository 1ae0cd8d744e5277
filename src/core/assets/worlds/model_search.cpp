#include "assets/worlds/model_search.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <vector>

#include "assets/references.h"

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
  for (const std::string& spelling : {name, decodeUri(name)}) {
    for (const fs::path& folder : modelFolders(file)) {
      // If a file inside of a model's folder names that model, the model is found from the folder above.
      if (!spelling.empty() && isThere(folder / spelling)) return folder / spelling;
    }
  }
  return std::nullopt;
}

fs::path findModel(const XmlNode& from, const fs::path& file, const std::string& uri) {
  if (uri.empty()) from.fail("names no file");
  if (uri.starts_with("http://") || uri.starts_with("https://")) {
    from.fail(fmt::format("names '{}', which is not a local file: download it and name the file", uri));
  }
  for (const std::string_view scheme : {"model://", "package://"}) {
    if (!uri.starts_with(scheme)) continue;
    if (const auto found = findInModelFolders(file, uri.substr(scheme.size()))) return *found;
    from.fail(
        fmt::format("names '{}', which is neither in '{}', nor in the folders above it, nor in the folders of the "
                    "variables {}: put it into one of these folders, or remove its name",
                    uri, file.parent_path().string(), fmt::join(kVariables, ", ")));
  }
  const std::string plain = uri.starts_with("file://") ? uri.substr(7) : uri;
  for (const std::string& name : {plain, decodeUri(plain)}) {
    fs::path found = file.parent_path() / name;
    if (isThere(found)) return found;
  }
  // A relative name may also be the name of a model.
  if (const auto found = findInModelFolders(file, plain)) return *found;
  from.fail(fmt::format("names '{}', but this file does not exist", uri));
}

}  // namespace scanmill
