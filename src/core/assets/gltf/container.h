#pragma once

// The files of glTF 2.0: .gltf, which is JSON, .glb, which holds the JSON and bytes beside it, and .b3dm of 3D
// Tiles 1.0, which holds a .glb.

#include <filesystem>
#include <optional>
#include <string>

#include "base/vec.h"

namespace scanmill::gltf {

struct Container {
  std::string json;
  std::string bin;              // the GLB's binary chunk
  std::optional<Vec3d> center;  // m, RTC_CENTER of a .b3dm, z up
};

// Throws InputError that calls the file `name` where a GLB or its frame is damaged, or of glTF 1.0.
Container readContainer(const std::filesystem::path& file, const std::filesystem::path& name);

}  // namespace scanmill::gltf
