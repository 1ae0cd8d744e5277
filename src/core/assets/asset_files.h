#pragma once

// The 3D files of a folder.

#include <filesystem>
#include <vector>

namespace scanmill {

// Returns the 3D files in a folder and its subfolders, sorted by path: the usual kinds that readAsset() reads, without
// those that are seldom assets (.json, .csv). Of a folder with a model.sdf, such as one of Gazebo's models, only that
// file is returned, since it names its meshes and their scale. Empty if there are none.
std::vector<std::filesystem::path> assetsIn(const std::filesystem::path& folder);

}  // namespace scanmill
