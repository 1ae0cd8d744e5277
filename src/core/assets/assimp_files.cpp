#include <assimp/DefaultIOSystem.h>
#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "assets/assimp_parts.h"
#include "assets/references.h"
#include "config/text.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;

class AssimpFiles final : public Assimp::DefaultIOSystem {
 public:
  AssimpFiles(const fs::path& asset, bool allowOutside, MissedFiles& missed)
      : folder_(fs::absolute(asset).lexically_normal().parent_path()),
        ownLibrary_(asset.stem().string() + ".mtl"),
        allowOutside_(allowOutside),
        missed_(missed) {}

  bool Exists(const char* name) const override {
    std::error_code ignored;
    return fs::is_regular_file(name, ignored);
  }

  Assimp::IOStream* Open(const char* name, const char* mode) override {
    std::error_code ignored;
    const fs::file_status status = fs::status(name, ignored);
    const std::string inFolder = fs::absolute(name).lexically_normal().lexically_relative(folder_).string();
    std::string refusal;
    if (fs::exists(status) && !fs::is_regular_file(status)) {
      refusal = fmt::format("names '{}', which is not a file", inFolder);
    } else if (fs::exists(status) && !allowOutside_ && leadsOutside(inFolder)) {
      refusal = refusalOf(inFolder);
    }
    if (!refusal.empty()) {
      if (missed_.refused.empty()) missed_.refused = refusal;
      return nullptr;
    }
    Assimp::IOStream* const stream = DefaultIOSystem::Open(name, mode);
    if (lowerExtension(name) == ".mtl") noteLibrary(inFolder, stream != nullptr);
    return stream;
  }

 private:
  void noteLibrary(const std::string& name, bool found) {
    std::vector<std::string>& missing = missed_.libraries;
    const bool known = std::find(missing.begin(), missing.end(), name) != missing.end();
    if (!found && !known && (missing.empty() || name != ownLibrary_)) missing.push_back(name);
    if (found && name == ownLibrary_) missing.clear();
  }

  fs::path folder_;
  std::string ownLibrary_;  // library with the asset's name, which the importer tries if another library is missing
  bool allowOutside_;
  MissedFiles& missed_;
};

}  // namespace

std::unique_ptr<Assimp::IOSystem> filesFor(const fs::path& asset, bool allowOutside, MissedFiles& missed) {
  return std::make_unique<AssimpFiles>(asset, allowOutside, missed);
}

}  // namespace scanmill
