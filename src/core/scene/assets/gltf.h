#pragma once

// Checks glTF 2.0 before it reaches the importer, and translates what the importer does not understand.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/assets/asset.h"

namespace scanmill {

// The text of a .gltf or the bytes of a .glb, reduced to what a static scene needs: nodes, triangles with positions and
// texture coordinates, materials, images; skins and morph targets as they are at the clip's time, or as the file has
// them at rest (scene/assets/gltf_pose.h). Every index, range and length in it has been checked against the files, the
// nodes form a tree, names of files are decoded ("textures%2Fa.webp" -> "textures/a.webp"), and textures that only an
// extension names (EXT_texture_webp and its kin) have a plain source. Throws InputError that names the file and what is
// wrong with it. Terms are those of the glTF 2.0 specification, chapters 3 and 4.
std::string checkedGltf(const std::filesystem::path& file, const std::optional<ClipTime>& clip);

// When the key frames of an animation begin and end (s). Throws InputError that names the file, with a suggestion where
// it has no animation of that name.
std::pair<double, double> clipSpan(const std::filesystem::path& file, const std::string& clip);

// The animations of a glTF file, in its order. Throws InputError that names the file.
struct GltfClip {
  std::string name;            // its number where it has none
  double first = 0, last = 0;  // when its key frames begin and end, s
};
std::vector<GltfClip> gltfClips(const std::filesystem::path& file);

// Decodes the escapes of a URI: "%2F" becomes "/". What is no escape stays as it is.
std::string decodeUri(std::string_view uri);

}  // namespace scanmill
