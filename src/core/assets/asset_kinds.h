#pragma once

// The kinds of files that can be read as assets, by the endings of their names.

#include <filesystem>
#include <string>
#include <vector>

namespace scanmill {

enum class AssetReader {
  None,     // the kind is unknown, or known and not read
  Gltf,     // assets/meshes/gltf/reader.h
  Blender,  // the installed Blender opens or imports the file
  Mesh,     // readImported()
  World,    // readWorld()
  Cloud,    // readCloudAsset()
  Heights,  // readHeightAsset()
};

// Returns the reader for the ending of a file's name, which does not reveal that a PLY without faces and some .asc are
// point clouds: call isCloud() in formats/cloud_file.h first.
AssetReader readerOf(const std::filesystem::path& file);

// Returns why a file whose kind has no reader is refused, and how it can be converted.
std::string whyNoReader(const std::filesystem::path& file);

// Returns what the first bytes of a file look like, such as "a PNG image", to explain why the reader for its ending
// fails; empty if the bytes fit the ending or are not recognised.
std::string otherContent(const std::filesystem::path& file);

// Returns the 3D files in a folder and its subfolders, sorted by path; empty if there are none. Files of most kinds
// that readAsset() reads are returned, but not .json and .csv, which are seldom assets. If a folder has a model.sdf, as
// Gazebo's models have, or a tileset.json, only this file is returned for the folder, since it names the meshes and
// their places. Warns of 3D files of other kinds, with counts.
std::vector<std::filesystem::path> assetsIn(const std::filesystem::path& folder);

}  // namespace scanmill
