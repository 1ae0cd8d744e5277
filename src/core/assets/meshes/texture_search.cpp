#include "assets/meshes/texture_search.h"

#include <algorithm>

#include "assets/meshes/model_folders.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "config/text.h"

namespace scanmill {

namespace {

bool isFile(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
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

std::filesystem::path findTexture(const std::filesystem::path& asset, const std::string& name, bool allowOutside,
                                  const std::vector<std::filesystem::path>& folders) {
  std::string plain = name;
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
  std::vector<std::filesystem::path> places{folder,
                                            folder / "textures",
                                            folder / "Textures",
                                            folder / ".." / "materials" / "textures",
                                            folder / ".." / "textures",
                                            folder / "materials" / "textures"};
  places.insert(places.end(), folders.begin(), folders.end());
  const std::string bare = std::filesystem::path(decodeUri(plain)).filename().string();
  if (bare.empty() || bare == "..") return {};
  for (const auto& place : places) candidates.push_back(place / bare);
  for (const auto& candidate : candidates) {
    if (isFile(candidate)) return candidate;
  }
  for (const auto& place : places) {
    if (auto found = findIgnoringCase(place.empty() ? "." : place, bare); !found.empty()) return found;
  }
  if (!outside.empty()) throw InputError({asset.string()}, refusalOf(name));
  // Some exporters write a name with blanks in quotation marks.
  if (name.size() > 2 && name.starts_with('"') && name.ends_with('"')) {
    return findTexture(asset, name.substr(1, name.size() - 2), allowOutside, folders);
  }
  return {};
}

}  // namespace scanmill
