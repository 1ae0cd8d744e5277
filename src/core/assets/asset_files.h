#pragma once

// The 3D files of a folder.

#include <filesystem>
#include <vector>

namespace scanmill {

// Those in it and in the folders below, in the order of their names, of the kinds that readAsset() reads, but for those
// that are seldom assets (.json, .csv). A folder that holds a model.sdf, as Gazebo's models do, is that file alone: it
// says by itself which meshes it has, and how large they are. Empty where there is none.
std::vector<std::filesystem::path> assetsIn(const std::filesystem::path& folder);

}  // namespace scanmill
