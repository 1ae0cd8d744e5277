#pragma once

// Where the numbers of a glTF file lie: buffers, buffer views and accessors.

#include "assets/gltf/json_reader.h"

namespace scanmill::gltf {

// Reads and checks them into the model, which has the GLB's binary chunk. `allowOutside`: see AssetOptions.
void readStorage(Model& model, const Json& json, bool allowOutside);

}  // namespace scanmill::gltf
