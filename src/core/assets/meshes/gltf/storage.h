#pragma once

// The files of glTF 2.0: .gltf, which is JSON; .glb, which contains JSON and binary data; and .b3dm of 3D Tiles 1.0,
// which contains a .glb. And the storage of numbers in them: buffers, buffer views and accessors.

#include <filesystem>
#include <optional>
#include <string>

#include "assets/meshes/gltf/json_reader.h"

namespace scanmill::gltf {

struct Container {
  std::string json;
  std::string bin;              // the GLB's binary chunk
  std::optional<Vec3d> center;  // m, RTC_CENTER of a .b3dm, z up
  bool batchTable = false;      // true if a .b3dm has a batch table with properties
};

// Reads a file. Throws an InputError that calls the file `name` if the .b3dm or its GLB is damaged, or if the GLB is of
// glTF 1.0.
Container readContainer(const std::filesystem::path& file, const std::filesystem::path& name);

// Reads buffers, views and accessors into the model and checks them. Model::bin and Model::file must be set before.
// `allowOutside`: see AssetOptions.
void readStorage(Model& model, const Json& json, bool allowOutside);

}  // namespace scanmill::gltf
