#pragma once

// The storage of numbers in a glTF file: buffers, buffer views and accessors.

#include "assets/meshes/gltf/json_reader.h"

namespace scanmill::gltf {

// Reads buffers, views and accessors into the model and checks them. Model::bin and Model::file must be set before.
// `allowOutside`: see AssetOptions.
void readStorage(Model& model, const Json& json, bool allowOutside);

}  // namespace scanmill::gltf
