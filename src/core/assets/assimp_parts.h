#pragma once

// The parts of the reader that uses the assimp library (assets/assimp_reader.h).

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "assets/imported_file.h"

struct aiScene;

namespace Assimp {
class IOSystem;
}

namespace scanmill {

// Returns the file access for the importer. It opens only regular files, no pipes or devices, and without
// `allowOutside` only files in the asset's folder and its subfolders. `refused` is set to the message about the first
// file that was refused, and must outlive the result.
std::unique_ptr<Assimp::IOSystem> filesFor(const std::filesystem::path& asset, bool allowOutside, std::string& refused);

// Returns the materials of an assimp scene. Base colours count as linear, since most exporters write linear ones.
std::vector<ImportedMaterial> materialsOf(const aiScene& scene);
// Returns the embedded images of an assimp scene. Throws Error if an image has no usable size.
std::vector<ImportedImage> imagesOf(const aiScene& scene);

}  // namespace scanmill
