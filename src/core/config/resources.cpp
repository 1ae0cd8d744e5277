#include "config/resources.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <system_error>
#include <vector>

#include "base/file.h"
#include "config/fields.h"
#include "config/text.h"
#include "config/version.h"

namespace scanmill {

namespace {

const char* advice(FileKind kind) {
  switch (kind) {
    case FileKind::Pipeline:
      return "this is a pipeline: give it to `scanmill generate` or `scanmill plan`";
    case FileKind::Scene:
      return "this is a scene: name it under `scenes:` of a pipeline";
    case FileKind::Sensor:
      return "this is a sensor: name it as `preset:` under `sensors:` of a pipeline";
    case FileKind::Ontology:
      return "this is an ontology: name it as `ontology:` of a scene, or as `labels:` of a pipeline";
    case FileKind::Materials:
      return "this is a material table: name it as `materials:` of a scene";
    case FileKind::Unknown:
      break;
  }
  return "";
}

}  // namespace

namespace fs = std::filesystem;

namespace {

constexpr const char* kSuffix = ".yaml";
constexpr std::string_view kProgramPrefix = "scanmill:";  // prefix of the saved paths of the program's own files

// Returns the file at this path, with or without the suffix .yaml; nullopt if there is no such file.
std::optional<fs::path> fileAt(const fs::path& path) {
  if (pathExists(path) && !isFolder(path)) return path;
  const fs::path withSuffix = path.string() + kSuffix;
  if (path.has_filename() && pathExists(withSuffix) && !isFolder(withSuffix)) return withSuffix;
  return std::nullopt;
}

// Returns the kind of all files in one of the program's folders; Unknown if the folder has several kinds.
FileKind kindIn(const fs::path& subfolder) {
  if (subfolder == "pipelines") return FileKind::Pipeline;
  if (subfolder == "pipelines/sensors") return FileKind::Sensor;
  return subfolder == "scenes" ? FileKind::Scene : FileKind::Unknown;
}

// Returns false if the YAML file is known to be of another kind than `expected`.
bool mayBe(FileKind expected, const fs::path& file) {
  if (expected == FileKind::Unknown) return true;
  try {
    const FileKind kind = fileKind(readYaml(file));
    return kind == FileKind::Unknown || kind == expected;
  } catch (const InputError&) {
    return true;  // the kind is unknown: the file is invalid, or needs an environment variable
  }
}

// Returns the names, without suffix, of the YAML files in a folder that are of this kind or of unknown kind.
std::set<std::string> yamlNames(const fs::path& folder, FileKind kind = FileKind::Unknown) {
  std::set<std::string> names;
  std::error_code unreadable;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder, unreadable)) {
    if (entry.path().extension() == kSuffix && mayBe(kind, entry.path())) names.insert(entry.path().stem().string());
  }
  return names;
}

// Returns `name` as a path that starts in the folder of the file that contains `value` or, if the value comes from
// --set, in the folder of the file that --set changes.
fs::path pathFromFile(const Value& value, const fs::path& name) {
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

}  // namespace

bool isPlainName(const std::string& name) {
  return name.find('/') == std::string::npos && !fs::path(name).has_extension();
}

fs::path resourceFolder() {
  if (const char* folder = std::getenv("SCANMILL_RESOURCES")) return folder;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = program.parent_path().parent_path() / "share" / "scanmill";
  return fs::is_directory(installed / "pipelines", ignored) ? installed : fs::path(kSourceFolder);
}

fs::path resolvePath(const Value& value, const std::string& name) {
  const fs::path path = pathFromFile(value, name);
  return !value.folder.empty() && !pathExists(path) && pathExists(name) ? fs::path(name) : path;
}

fs::path resolveResource(const Value& value, const std::string& name, const std::string& subfolder) {
  const fs::path path = pathFromFile(value, name);
  const bool isFromOtherFolder = !value.folder.empty() && path != name;  // true: --set also searches the current folder
  const auto userFile = [&](const std::string& userName) {
    const auto file = fileAt(pathFromFile(value, userName));
    return !file && isFromOtherFolder ? fileAt(userName) : file;
  };
  const auto programFile = builtIn(name, subfolder);
  if (isPlainName(name)) {
    const auto file = userFile(name + kSuffix);
    std::error_code ignored;
    if (programFile && file && !fs::equivalent(*file, *programFile, ignored)) {
      warn(
          "{0}'{1}' is taken from the files that come with the program, not from {2}: to take that, write "
          "{1}{3}",
          value.where.file.empty() ? "" : value.where.text() + ": ", name, file->string(), kSuffix);
    }
    if (programFile || file) return programFile ? *programFile : *file;
    if (const auto bareFile = userFile(name)) {
      throw InputError(value.where,
                       "'{0}' is not among the files that come with the program; to take the "
                       "file {1}, write ./{0}",
                       name, bareFile->string());
    }
  } else {
    if (const auto file = userFile(name)) return *file;
    if (programFile) return *programFile;
  }
  std::vector<fs::path> searchedFolders{path.parent_path(), resourceFolder() / subfolder};
  std::string message = fmt::format("there is no file '{}'", path.string());
  if (isFromOtherFolder) {
    searchedFolders.push_back(fs::path(name).parent_path());
    message += fmt::format(", nor '{}' in the current folder", name);
  }
  std::set<std::string> fileNames;  // a set, since two of the folders may be the same
  for (const fs::path& folder : searchedFolders) fileNames.merge(yamlNames(folder, kindIn(subfolder)));
  throw InputError(value.where,
                   message + suggestion(fs::path(name).stem().string(), {fileNames.begin(), fileNames.end()}));
}

fs::path namedResource(const std::string& name, const std::string& subfolder) {
  return resolveResource(scalarValue(name), name, subfolder);
}

std::set<std::string> resourceNames(const std::string& subfolder) {
  return yamlNames(resourceFolder() / subfolder);
}

std::string nearestResource(const std::string& name, const std::string& subfolder) {
  const fs::path path = name;
  if (path.has_parent_path() || (path.has_extension() && path.extension() != kSuffix)) return {};
  const std::set<std::string> names = resourceNames(subfolder);
  return nearest(path.stem().string(), {names.begin(), names.end()});
}

std::string savedPath(const fs::path& file, const fs::path& folder) {
  const fs::path absolute = fs::absolute(file).lexically_normal();
  const fs::path inResources = absolute.lexically_relative(fs::absolute(resourceFolder()).lexically_normal());
  if (!inResources.empty() && *inResources.begin() != "..") {
    return std::string(kProgramPrefix) + inResources.generic_string();
  }
  return absolute.lexically_relative((fs::current_path() / folder).lexically_normal()).generic_string();
}

fs::path fileOfSavedPath(const std::string& saved, const fs::path& folder) {
  if (saved.starts_with(kProgramPrefix)) return resourceFolder() / saved.substr(kProgramPrefix.size());
  return (folder / saved).lexically_normal();
}

FileKind fileKind(const Value& root) {
  if (root.find("scenes") != nullptr || root.find("sensors") != nullptr) return FileKind::Pipeline;
  if (root.find("objects") != nullptr) return FileKind::Scene;
  for (const char* key : {"elevation_deg", "calibration", "rosette", "raster", "lines", "beams", "pattern"}) {
    if (root.find(key) != nullptr) return FileKind::Sensor;
  }
  if (root.find("classes") != nullptr) return FileKind::Ontology;
  const Value* materials = root.find("materials");
  if (materials != nullptr && materials->kind == Value::Kind::Sequence) return FileKind::Materials;
  return FileKind::Unknown;
}

void expectKind(const Value& root, FileKind expected) {
  const FileKind kind = fileKind(root);
  if (kind != FileKind::Unknown && kind != expected) throw InputError({root.where.file}, advice(kind));
}

bool isMap(const std::filesystem::path& file) {
  constexpr const char* kEndings[] = {".osm", ".osh", ".pbf", ".o5m", ".opl"};
  const std::string name = lowerCase(file.filename().string());
  return std::any_of(std::begin(kEndings), std::end(kEndings),
                     [&](const char* ending) { return name.find(ending) != std::string::npos; });
}

std::string firstBytes(const std::filesystem::path& file, std::size_t count) {
  std::string bytes(count, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), std::ssize(bytes));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

}  // namespace scanmill
