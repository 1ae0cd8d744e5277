#pragma once

// Finds the 3D files of a folder.

#include <filesystem>
#include <vector>

namespace scanmill {

// Returns the 3D files in a folder and its subfolders, sorted by path; empty if there are none. Files of most kinds
// that readAsset() reads are returned, but not .json and .csv, which are seldom assets. If a folder has a model.sdf, as
// Gazebo's models have, or a tileset.json, only this file is returned for the folder, since it names the meshes and
// their places. Warns of 3D files of other kinds, with counts.
std::vector<std::filesystem::path> assetsIn(const std::filesystem::path& folder);

}  // namespace scanmill
