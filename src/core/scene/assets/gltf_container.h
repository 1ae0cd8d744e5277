#pragma once

// The two files of glTF 2.0: .gltf, which is JSON, and .glb, which holds the JSON and bytes beside it.

#include <filesystem>
#include <string>

namespace scanmill {

struct GltfContainer {
  std::string json;
  std::string bin;      // the GLB's binary chunk
  bool binary = false;  // a GLB
};

// Throws InputError that names the file where a GLB is damaged, or of glTF 1.0.
GltfContainer readGltfContainer(const std::filesystem::path& file);

// The bytes of such a file. Throws InputError that names it where a GLB cannot be as large.
std::string packGltf(GltfContainer container, const std::filesystem::path& file);

}  // namespace scanmill
