#include "assets/worlds/named_files.h"

#include <fmt/format.h>

#include <set>

#include "assets/meshes/references.h"
#include "base/file.h"

namespace scanmill {

void tellMissing(const std::vector<MissingFileError>& missing, bool leaveOut, LeftOut& leftOut) {
  if (leaveOut) {
    for (const MissingFileError& e : missing) leftOut.add(fmt::format("missing models and meshes ('{}')", e.name));
    return;
  }
  if (missing.empty()) return;
  const MissingFileError& first = missing.front();
  std::set<std::string> named{first.name};
  std::string others;
  for (const MissingFileError& e : missing) {
    if (!named.insert(e.name).second) continue;
    const bool sameFile = e.where.file == first.where.file && e.where.line > 0;
    others += fmt::format("{} '{}' ({})", others.empty() ? "" : ",", e.name,
                          sameFile ? fmt::format("line {}", e.where.line) : e.where.text());
  }
  throw InputError(fmt::format(
      "{}{}{}; `missing: leave_out` of the object (--leave-out-missing of `info` and `draft`) goes on without {}",
      first.what(), others.empty() ? "" : "; further ones are missing:", others, named.size() == 1 ? "it" : "them"));
}

std::filesystem::path findModel(const XmlNode& from, const std::filesystem::path& file, const std::string& uri) {
  if (uri.empty()) from.fail("names no file");
  const auto missing = [&](const std::string& why) {
    return MissingFileError(from.where, uri, fmt::format("<{}> names '{}', {}", from.name, uri, why));
  };
  if (uri.starts_with("http://") || uri.starts_with("https://")) {
    throw missing("which is not a local file: download it and name the file");
  }
  for (const std::string_view scheme : {"model://", "package://"}) {
    if (!uri.starts_with(scheme)) continue;
    const std::string name = uri.substr(scheme.size());
    if (const auto found = findInModelFolders(file, name)) return *found;
    const std::string folder = name.substr(0, name.find('/'));
    if (const auto found = findInModelFolders(file, folder); found && folder.size() < name.size()) {
      throw missing(fmt::format("but '{}' has no file '{}'", found->string(), name.substr(folder.size() + 1)));
    }
    throw missing(
        fmt::format("which is neither in '{}', nor in the folders above it, nor in the folders of the variables {}: a "
                    "folder must have the name '{}' (a name in package.xml does not count)",
                    file.parent_path().string(), modelFolderVariables(), folder));
  }
  const std::string plain = uri.starts_with("file://") ? uri.substr(7) : uri;
  for (const std::string& name : {plain, decodeUri(plain)}) {
    std::filesystem::path found = file.parent_path() / name;
    if (pathExists(found)) return found;
  }
  // A relative name may also be the name of a model.
  if (const auto found = findInModelFolders(file, plain)) return *found;
  throw missing("but this file does not exist");
}

}  // namespace scanmill
