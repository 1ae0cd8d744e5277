#pragma once

// Finds the models and meshes that world descriptions name.

#include <filesystem>
#include <string>

#include "assets/worlds/missing_files.h"
#include "assets/worlds/xml.h"

namespace scanmill {

// Returns the file or folder that the element `from` of `file` calls `uri`: model://NAME/..., package://NAME/... (see
// assets/meshes/model_folders.h), file://... or a path relative to the file. Throws MissingFileError at `from` if
// nothing is found.
std::filesystem::path findModel(const XmlNode& from, const std::filesystem::path& file, const std::string& uri);

}  // namespace scanmill
