#pragma once

#include <vector>

#include "assets/imported_file.h"

struct aiScene;

namespace scanmill {

// Returns the materials of an assimp scene. Base colours count as linear, since most exporters write linear ones.
std::vector<ImportedMaterial> materialsOf(const aiScene& scene);
// Returns the embedded images of an assimp scene. Throws Error if an image has no usable size.
std::vector<ImportedImage> imagesOf(const aiScene& scene);

}  // namespace scanmill
