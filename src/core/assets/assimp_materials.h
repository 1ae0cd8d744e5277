#pragma once

#include <vector>

#include "assets/imported_file.h"

struct aiScene;

namespace scanmill {

// The materials and embedded images of a scene in the importer's terms. Base colours are taken as linear, which is what
// most exporters write.
std::vector<ImportedMaterial> materialsOf(const aiScene& scene);
// Throws Error where an image has no usable size.
std::vector<ImportedImage> imagesOf(const aiScene& scene);

}  // namespace scanmill
