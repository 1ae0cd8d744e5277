#include "scene/assets/assimp_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "config/text.h"
#include "scene/assets/references.h"

namespace scanmill {

namespace fs = std::filesystem;

AssimpFiles::AssimpFiles(const fs::path& asset, bool allowOutside)
    : folder_(fs::absolute(asset).lexically_normal().parent_path()),
      ownLibrary_(asset.stem().string() + ".mtl"),
      allowOutside_(allowOutside) {}

std::string AssimpFiles::named(const char* name) const {
  return fs::absolute(name).lexically_normal().lexically_relative(folder_).string();
}

bool AssimpFiles::Exists(const char* name) const {
  std::error_code ignored;
  return fs::is_regular_file(name, ignored);
}

Assimp::IOStream* AssimpFiles::Open(const char* name, const char* mode) {
  std::error_code ignored;
  const fs::file_status status = fs::status(name, ignored);
  const std::string inFolder = named(name);
  std::string refusal;
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    refusal = fmt::format("names '{}', which is not a file", inFolder);
  } else if (fs::exists(status) && !allowOutside_ && leadsOutside(inFolder)) {
    refusal = refusalOf(inFolder);
  }
  if (!refusal.empty()) {
    if (refused_.empty()) refused_ = refusal;
    return nullptr;
  }
  Assimp::IOStream* const stream = DefaultIOSystem::Open(name, mode);
  if (lowerExtension(name) == ".mtl") {
    const bool known = std::find(missing_.begin(), missing_.end(), inFolder) != missing_.end();
    if (stream == nullptr && !known && (missing_.empty() || inFolder != ownLibrary_)) missing_.push_back(inFolder);
    if (stream != nullptr && inFolder == ownLibrary_) missing_.clear();
  }
  return stream;
}

}  // namespace scanmill
