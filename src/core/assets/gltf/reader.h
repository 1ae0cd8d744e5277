#pragma once

// Reads glTF 2.0, .gltf and .glb, with what its extensions say of geometry: KHR_mesh_quantization,
// EXT_meshopt_compression, KHR_draco_mesh_compression, EXT_mesh_gpu_instancing, KHR_node_visibility and
// KHR_texture_transform; skins and morph targets as they are at rest or at AssetOptions::clip.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "assets/asset.h"

namespace scanmill::gltf {

// Reads the file as readAsset() does. It is called `name` in messages, beside which the files lie that it names.
// `assetFromFile` takes coordinates of the file to those of the asset.
Asset readAsset(const std::filesystem::path& file, const std::filesystem::path& name, const Affine& assetFromFile,
                const AssetOptions& options);

// Likewise the content of a tile of 3D Tiles. `assetFromTile` takes the tile's coordinates (m, z up, relative to
// nothing) to those of the asset; `zUpFromGltf` says which axis of its glTF is up.
Asset readTile(const std::filesystem::path& file, const Affine& assetFromTile, const Mat3& zUpFromGltf,
               const AssetOptions& options);

// The animations of a file, in its order. Throws InputError that names the file.
struct Clip {
  std::string name;            // its number where it has none
  double first = 0, last = 0;  // when its key frames begin and end, s
};
std::vector<Clip> readClips(const std::filesystem::path& file);

// When the key frames of an animation begin and end (s). Throws InputError that names the file, with a suggestion where
// it has no animation of that name.
std::pair<double, double> clipSpan(const std::filesystem::path& file, const std::string& clip);

}  // namespace scanmill::gltf
