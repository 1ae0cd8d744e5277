#pragma once

// The two files of glTF 2.0: .gltf, which is JSON, and .glb, which holds the JSON and bytes beside it.

#include <filesystem>
#include <string>

namespace scanmill::gltf {

struct Container {
  std::string json;
  std::string bin;  // the GLB's binary chunk
};

// Throws InputError that calls the file `name` where a GLB is damaged, or of glTF 1.0.
Container readContainer(const std::filesystem::path& file, const std::filesystem::path& name);

}  // namespace scanmill::gltf
