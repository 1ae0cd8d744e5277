#pragma once

// Reads glTF 2.0 (.gltf, .glb, .b3dm) with the extensions in kGltfFormat. Skins and morph targets have the pose that
// the file states or, if AssetOptions::clip is set, the pose at its time.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "base/format_support.h"

namespace scanmill::gltf {

// Reads the file as scanmill::readAsset() does. Messages call the file `name`; other files are searched for relative to
// the folder of `name`. `assetFromFile` transforms coordinates of the file to the asset's frame.
Asset readAsset(const std::filesystem::path& file, const std::filesystem::path& name, const Affine& assetFromFile,
                const AssetOptions& options);

// Reads the content of a tile of 3D Tiles as readAsset() reads a file. `assetFromTile` transforms the tile's
// coordinates (m, z up, with RTC_CENTER added) to the asset's frame; `zUpFromGltf` rotates the up axis of the tile's
// glTF to z. Adds contents that are not read to `leftOut`, instead of warning of them.
Asset readTile(const std::filesystem::path& file, const Affine& assetFromTile, const Mat3& zUpFromGltf,
               const AssetOptions& options, LeftOut& leftOut);

// An animation of a file.
struct Clip {
  std::string name;            // name of the animation; its number if it has no name
  double first = 0, last = 0;  // s, times of the first and the last key frame
};
// Returns the animations of a file that have key frames, in the file's order. Throws an InputError that names the file.
std::vector<Clip> readClips(const std::filesystem::path& file);

// Returns the times of an animation's first and last key frame (s). Throws an InputError that names the file, with a
// suggestion if the file has no animation of this name.
std::pair<double, double> clipSpan(const std::filesystem::path& file, const std::string& clip);

}  // namespace scanmill::gltf
