#include "assets/worlds/model_search.h"

#include <fmt/format.h>

#include "assets/meshes/model_folders.h"
#include "assets/meshes/references.h"

namespace scanmill {

namespace fs = std::filesystem;

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
                    "variables {}: a folder must have the name '{}' (a name in package.xml does not count)",
                    uri, file.parent_path().string(), modelFolderVariables(),
                    uri.substr(scheme.size(), uri.find('/', scheme.size()) - scheme.size())));
  }
  const std::string plain = uri.starts_with("file://") ? uri.substr(7) : uri;
  for (const std::string& name : {plain, decodeUri(plain)}) {
    fs::path found = file.parent_path() / name;
    std::error_code ignored;
    if (fs::exists(found, ignored)) return found;
  }
  // A relative name may also be the name of a model.
  if (const auto found = findInModelFolders(file, plain)) return *found;
  from.fail(fmt::format("names '{}', but this file does not exist", uri));
}

}  // namespace scanmill
