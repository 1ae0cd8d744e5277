#include "assets/meshes/references.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"
#include "config/text.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLevels = 8;  // largest number of folders to search, from the file's folder upwards
constexpr const char* kVariables[] = {"SDF_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH",
                                      "GAZEBO_MODEL_PATH", "ROS_PACKAGE_PATH"};

// Returns the folders in which findInModelFolders() searches, the nearest first.
std::vector<fs::path> modelFolders(const fs::path& file) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  fs::path folder = fs::absolute(file, ignored).lexically_normal().parent_path();
  for (int level = 0; level < kMostLevels; ++level) {
    folders.push_back(folder);
    folders.push_back(folder / "models");
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  for (const char* variable : kVariables) {
    const char* const value = std::getenv(variable);
    std::vector<std::string_view> listedFolders;
    splitCells(value == nullptr ? "" : value, ':', listedFolders);
    for (const std::string_view listed : listedFolders) {
      if (!listed.empty()) folders.emplace_back(listed);
    }
  }
  return folders;
}

// Returns the file of this name in a folder, ignoring case: the first by name if there are several, empty if none.
fs::path findIgnoringCase(const fs::path& folder, const std::string& name) {
  std::error_code error;
  fs::path first;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (lowerCase(entry.path().filename().string()) != lowerCase(name) || !isFile(entry.path())) continue;
    if (first.empty() || entry.path() < first) first = entry.path();
  }
  return first;
}

}  // namespace

bool leadsOutside(const std::string& name) {
  const fs::path path = fs::path(name).lexically_normal();
  return path.is_absolute() || (!path.empty() && *path.begin() == "..");
}

std::string refusalOf(const std::string& name) {
  return fmt::format(
      "names '{}', which lies outside its folder: move that file into the folder, or allow it by `allow_outside: true` "
      "of the object (--allow-outside of `info` and `draft`)",
      name);
}

std::string decodeUri(std::string_view uri) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned byte = 0;
    const char* const digits = uri.data() + i + 1;  // two hexadecimal digits behind a %
    const bool isEscape =
        uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
    decoded += isEscape ? static_cast<char>(byte) : uri[i];
    if (isEscape) i += 2;
  }
  return decoded;
}

std::optional<fs::path> findInModelFolders(const fs::path& file, const std::string& name) {
  for (const fs::path& folder : modelFolders(file)) {
    for (const std::string& spelling : {name, decodeUri(name)}) {
      // A file in the folder of the model M may itself name M, which is found in the folder above.
      if (!spelling.empty() && pathExists(folder / spelling)) return folder / spelling;
    }
  }
  return std::nullopt;
}

std::string modelFolderVariables() {
  return fmt::format("{}", fmt::join(kVariables, ", "));
}

fs::path findTexture(const fs::path& asset, const std::string& name, bool allowOutside,
                     const std::vector<fs::path>& folders) {
  std::string uri = name;  // no backslashes and no scheme; escapes are not decoded
  std::ranges::replace(uri, '\\', '/');
  if (uri.starts_with("file://")) uri = uri.substr(7);
  if (uri.starts_with("model://")) {  // Gazebo: model://MODEL/...; all models are in one folder
    uri = uri.substr(8);
    const bool isInside = !leadsOutside(uri) && !leadsOutside(decodeUri(uri));
    const auto path = isInside ? findInModelFolders(asset, uri) : std::nullopt;
    if (path && isFile(*path)) return *path;
  }
  const fs::path folder = asset.parent_path();
  bool isOutside = false;  // true: the name leads to a file outside of the asset's folder
  for (const std::string& spelling : {uri, decodeUri(uri)}) {
    const fs::path path = folder / spelling;  // `folder` is ignored if the spelling is absolute
    if (!isFile(path)) continue;
    if (allowOutside || !leadsOutside(spelling)) return path;
    isOutside = true;
  }
  const std::string fileName = fs::path(decodeUri(uri)).filename().string();
  if (fileName.empty() || fileName == "..") return {};
  std::vector<fs::path> searched{folder,
                                 folder / "textures",
                                 folder / "Textures",
                                 folder / ".." / "materials" / "textures",
                                 folder / ".." / "textures",
                                 folder / "materials" / "textures"};
  searched.insert(searched.end(), folders.begin(), folders.end());
  for (const fs::path& searchedFolder : searched) {
    if (isFile(searchedFolder / fileName)) return searchedFolder / fileName;
  }
  for (const fs::path& searchedFolder : searched) {
    const fs::path path = findIgnoringCase(searchedFolder.empty() ? "." : searchedFolder, fileName);
    if (!path.empty()) return path;
  }
  if (isOutside) throw InputError({asset.string()}, refusalOf(name));
  // Some exporters write a name with blanks in quotation marks.
  if (name.size() > 2 && name.starts_with('"') && name.ends_with('"')) {
    return findTexture(asset, name.substr(1, name.size() - 2), allowOutside, folders);
  }
  return {};
}

}  // namespace scanmill
