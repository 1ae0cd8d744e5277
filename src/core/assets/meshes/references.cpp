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

constexpr int kMostAbove = 8;  // largest number of folders to search, from the file's folder upwards
constexpr const char* kVariables[] = {"SDF_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH",
                                      "GAZEBO_MODEL_PATH", "ROS_PACKAGE_PATH"};

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
    std::vector<std::string_view> listed;
    splitCells(value == nullptr ? "" : value, ':', listed);
    for (const std::string_view folder : listed) {
      if (!folder.empty()) folders.emplace_back(folder);
    }
  }
  return folders;
}

// Returns the file of this name in a folder, ignoring case; empty if there is none.
std::filesystem::path findIgnoringCase(const std::filesystem::path& folder, const std::string& name) {
  std::error_code error;
  std::filesystem::path best;  // the first match by name, since a folder's entries have no stable order
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (lowerCase(entry.path().filename().string()) != lowerCase(name) || !isFile(entry.path())) continue;
    if (best.empty() || entry.path() < best) best = entry.path();
  }
  return best;
}

}  // namespace

bool leadsOutside(const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(name).lexically_normal();
  return path.is_absolute() || (!path.empty() && *path.begin() == "..");
}

std::string refusalOf(const std::string& name) {
  return fmt::format(
      "names '{}', which lies outside its folder: move that file into the folder, or allow it by `allow_outside: true` "
      "of the object (--allow-outside of `info` and `draft`)",
      name);
}

std::string decodeUri(std::string_view uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned byte = 0;
    const char* const digits = uri.data() + i + 1;
    const bool isEscape =
        uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
    out += isEscape ? static_cast<char>(byte) : uri[i];
    if (isEscape) i += 2;
  }
  return out;
}

std::optional<fs::path> findInModelFolders(const fs::path& file, const std::string& name) {
  for (const fs::path& folder : modelFolders(file)) {
    for (const std::string& spelling : {name, decodeUri(name)}) {
      // If a file inside of a model's folder names that model, the model is found from the folder above.
      if (!spelling.empty() && pathExists(folder / spelling)) return folder / spelling;
    }
  }
  return std::nullopt;
}

std::string modelFolderVariables() {
  return fmt::format("{}", fmt::join(kVariables, ", "));
}

std::filesystem::path findTexture(const std::filesystem::path& asset, const std::string& name, bool allowOutside,
                                  const std::vector<std::filesystem::path>& folders) {
  std::string plain = name;  // with slashes and without a scheme, but with the escapes of a URI
  std::replace(plain.begin(), plain.end(), '\\', '/');
  const std::filesystem::path folder = asset.parent_path();
  std::vector<std::filesystem::path> candidates;
  std::filesystem::path outside;
  if (plain.starts_with("file://")) plain = plain.substr(7);
  if (plain.starts_with("model://")) {  // Gazebo: model://MODEL/...; all models are in one folder
    plain = plain.substr(8);
    if (!leadsOutside(plain) && !leadsOutside(decodeUri(plain))) {
      if (const auto found = findInModelFolders(asset, plain)) candidates.push_back(*found);
    }
  }
  for (const std::string& spelling : {plain, decodeUri(plain)}) {
    const std::filesystem::path path = folder / spelling;  // `folder` is ignored if the spelling is absolute
    if (allowOutside || !leadsOutside(spelling)) {
      candidates.push_back(path);
    } else if (isFile(path)) {
      outside = path;
    }
  }
  std::vector<std::filesystem::path> searched{folder,
                                              folder / "textures",
                                              folder / "Textures",
                                              folder / ".." / "materials" / "textures",
                                              folder / ".." / "textures",
                                              folder / "materials" / "textures"};
  searched.insert(searched.end(), folders.begin(), folders.end());
  const std::string fileName = std::filesystem::path(decodeUri(plain)).filename().string();
  if (fileName.empty() || fileName == "..") return {};
  for (const auto& searchedFolder : searched) candidates.push_back(searchedFolder / fileName);
  for (const auto& candidate : candidates) {
    if (isFile(candidate)) return candidate;
  }
  for (const auto& searchedFolder : searched) {
    if (auto found = findIgnoringCase(searchedFolder.empty() ? "." : searchedFolder, fileName); !found.empty())
      return found;
  }
  if (!outside.empty()) throw InputError({asset.string()}, refusalOf(name));
  // Some exporters write a name with blanks in quotation marks.
  if (name.size() > 2 && name.starts_with('"') && name.ends_with('"')) {
    return findTexture(asset, name.substr(1, name.size() - 2), allowOutside, folders);
  }
  return {};
}

}  // namespace scanmill
