#pragma once

#include <assimp/DefaultIOSystem.h>

#include <filesystem>
#include <string>
#include <vector>

namespace scanmill {

// What the importer may open: files, and no pipes or devices, in the asset's folder and below unless all is allowed.
class AssimpFiles final : public Assimp::DefaultIOSystem {
 public:
  AssimpFiles(const std::filesystem::path& asset, bool allowOutside);

  bool Exists(const char* name) const override;
  Assimp::IOStream* Open(const char* name, const char* mode) override;

  // What to say of the first file that it wanted and may not have; empty where there was none.
  const std::string& refused() const { return refused_; }
  // Libraries of materials that it wanted and that are not there.
  const std::vector<std::string>& missingLibraries() const { return missing_; }

 private:
  // From the folder of the asset.
  std::string named(const char* name) const;

  std::filesystem::path folder_;
  std::string ownLibrary_;  // of the asset's name, which is tried where another one is missing
  bool allowOutside_;
  std::string refused_;
  std::vector<std::string> missing_;
};

}  // namespace scanmill
