#include <assimp/DefaultIOSystem.h>
#include <fmt/format.h>

#include <system_error>

#include "assets/meshes/assimp/parts.h"
#include "assets/meshes/references.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;

class AssimpFiles final : public Assimp::DefaultIOSystem {
 public:
  AssimpFiles(const fs::path& asset, bool allowOutside, std::string& refused)
      : folder_(fs::absolute(asset).lexically_normal().parent_path()), allowOutside_(allowOutside), refused_(refused) {}

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
      if (refused_.empty()) refused_ = refusal;
      return nullptr;
    }
    return DefaultIOSystem::Open(name, mode);
  }

 private:
  fs::path folder_;
  bool allowOutside_;
  std::string& refused_;
};

}  // namespace

std::unique_ptr<Assimp::IOSystem> filesFor(const fs::path& asset, bool allowOutside, std::string& refused) {
  return std::make_unique<AssimpFiles>(asset, allowOutside, refused);
}

}  // namespace scanmill
