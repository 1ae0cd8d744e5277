#include "config/resources.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "config/fields.h"
#include "config/version.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kSuffix = ".yaml";

bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// Returns the file at this path, with or without the suffix .yaml; nullopt if there is no such file.
std::optional<fs::path> fileAt(const fs::path& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored) && !fs::is_directory(path, ignored)) return path;
  const fs::path whole = path.string() + kSuffix;
  if (path.has_filename() && fs::exists(whole, ignored) && !fs::is_directory(whole, ignored)) return whole;
  return std::nullopt;
}

std::vector<std::string> yamlNames(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code unreadable;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder, unreadable)) {
    if (entry.path().extension() == kSuffix) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path ownPath(const Value& value, const fs::path& name) {
  if (name.is_absolute()) return name;
  if (value.folder == ".") return name;  // the value comes from --set on a file of the current folder
  return (value.folder.empty() ? fs::path(value.where.file).parent_path() : fs::path(value.folder)) / name;
}

// Returns the file with this name, such as "os1_128" or "sensors/os1_128.yaml", that comes with the program; nullopt if
// there is none. A path that is absolute or starts with "." or ".." is not such a name.
std::optional<fs::path> builtIn(const fs::path& name, const fs::path& subfolder) {
  if (name.empty() || name.is_absolute() || *name.begin() == ".." || *name.begin() == ".") return std::nullopt;
  const fs::path root = resourceFolder();
  for (const fs::path& folder : {subfolder, subfolder.parent_path()}) {
    const fs::path inside = (folder / name).lexically_normal();
    if (*inside.begin() == "..") continue;
    if (auto file = fileAt(root / inside)) return file;
  }
  return std::nullopt;
}

// Returns a hint such as " (did you mean 'street.yaml'?)" from the files of the folders; if no file has a similar name,
// the names of the files that come with the program.
std::string advice(const fs::path& path, const std::vector<fs::path>& folders, const fs::path& builtInFolder) {
  std::string word = path.filename().string();
  if (path.extension() != kSuffix) word += kSuffix;
  std::vector<std::string> names;
  for (const fs::path& folder : folders) {
    for (std::string& name : yamlNames(folder)) names.push_back(std::move(name));
  }
  const std::string near = nearest(word, names);
  if (!near.empty()) {
    const bool own =
        std::any_of(folders.begin(), folders.end() - 1, [&](const fs::path& f) { return isThere(f / near); });
    return fmt::format(" (did you mean '{}'{}?)", near, own ? "" : ", which comes with the program");
  }
  std::vector<std::string> stems;
  for (const std::string& name : yamlNames(builtInFolder)) stems.push_back(fs::path(name).stem().string());
  return stems.empty() ? "" : fmt::format(" (the program comes with {})", fmt::join(stems, ", "));
}

}  // namespace

fs::path resourceFolder() {
  if (const char* folder = std::getenv("SCANMILL_RESOURCES")) return folder;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = program.parent_path().parent_path() / "share" / "scanmill";
  return fs::is_directory(installed / "pipelines", ignored) ? installed : fs::path(kSourceFolder);
}

fs::path resolvePath(const Value& value, const std::string& name) {
  const fs::path own = ownPath(value, name);
  return !value.folder.empty() && !isThere(own) && isThere(name) ? fs::path(name) : own;
}

fs::path resolveResource(const Value& value, const std::string& name, const std::string& subfolder) {
  const fs::path own = ownPath(value, name);
  if (const auto file = fileAt(own)) return *file;
  const bool elsewhere = !value.folder.empty() && own != name;
  if (elsewhere) {
    if (const auto file = fileAt(name)) return *file;
  }
  if (const auto file = builtIn(name, subfolder)) return *file;
  std::vector<fs::path> folders{own.parent_path()};
  std::string places = "there is no file " + fmt::format("'{}'", own.string());
  if (elsewhere) {
    folders.push_back(fs::path(name).parent_path());
    places += fmt::format(", nor '{}' in the current folder", name);
  }
  folders.push_back(resourceFolder() / subfolder);
  throw InputError(value.where, places + advice(name, folders, folders.back()));
}

fs::path namedResource(const std::string& name, const std::string& subfolder) {
  Value value;
  value.kind = Value::Kind::Scalar;
  value.text = name;
  return resolveResource(value, name, subfolder);
}

}  // namespace scanmill
