#include "commands/recorded_scans.h"

#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "formats/format.h"

namespace scanmill {

std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& what) {
  std::string text = parsed.options.count(option) == 0 ? std::string() : parsed.options[option].as<std::string>();
  if (text.empty()) throw InputError(fmt::format("--{} is missing: {}", option, what));
  return text;
}

void expectScan(const std::string& file) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(file, ignored) ||
      std::filesystem::exists(std::filesystem::path(file) / "manifest.json", ignored)) {
    return;
  }
  std::vector<std::string> frames;
  for (const auto& entry : std::filesystem::directory_iterator(file, ignored)) {
    const std::string suffix = entry.path().extension().string();
    if (suffix.size() > 1 && formatBySuffix(suffix.substr(1)) != nullptr) frames.push_back(entry.path().string());
  }
  if (frames.empty()) throw InputError({file}, "is a folder that holds no scan: name the recorded frames' files");
  std::sort(frames.begin(), frames.end());
  const std::string all =
      (std::filesystem::path(file) / "*").string() + std::filesystem::path(frames[0]).extension().string();
  throw InputError({file}, fmt::format("is a folder: name the scans in it, such as {} (all {}: {})", frames.front(),
                                       frames.size(), all));
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
