#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace Assimp {
class IOSystem;
}

namespace scanmill {

// What the importer wanted and did not get.
struct MissedFiles {
  std::string refused;                 // what to say of the first one that it may not have; empty: there was none
  std::vector<std::string> libraries;  // of materials, which are not there
};

// What the importer may open: files, and no pipes or devices, in the asset's folder and below unless all is allowed.
// `missed` outlives it.
std::unique_ptr<Assimp::IOSystem> filesFor(const std::filesystem::path& asset, bool allowOutside, MissedFiles& missed);

}  // namespace scanmill
