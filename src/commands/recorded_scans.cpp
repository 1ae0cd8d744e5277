#include "commands/recorded_scans.h"

#include <fmt/core.h>

#include "base/error.h"
#include "imports/scan_folder.h"

namespace scanmill {

std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& what) {
  std::string text = parsed.options.count(option) == 0 ? std::string() : parsed.options[option].as<std::string>();
  if (text.empty()) throw InputError(fmt::format("--{} is missing: {}", option, what));
  return text;
}

std::vector<std::string> scanFiles(const std::vector<std::string>& given) {
  std::vector<std::string> files;
  for (const std::string& file : given) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(file, ignored) ||
        std::filesystem::exists(std::filesystem::path(file) / "manifest.json", ignored)) {
      files.push_back(file);
      continue;
    }
    const auto found = scanFolderIn(file);
    if (!found)
      throw InputError({file}, "is a folder that holds no scan: name the recorded frames' files or their folder");
    for (const FolderScan& scan : found->scans) files.push_back(scan.points.string());
  }
  return files;
}

std::filesystem::path requiredFile(const Arguments& parsed, const std::string& what) {
  std::filesystem::path out = requiredText(parsed, "out", what);
  std::error_code ignored;
  if (std::filesystem::is_directory(out, ignored)) throw InputError({out.string()}, "is a folder: name a file");
  if (std::filesystem::exists(out, ignored) && parsed.options.count("overwrite") == 0) {
    throw InputError({out.string()}, "exists: choose another name or pass --overwrite");
  }
  return out;
}

}  // namespace scanmill
