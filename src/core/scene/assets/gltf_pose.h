#pragma once

// Poses what a glTF file animates: nodes, skins and morph targets (glTF 2.0, 3.7.2.2, 3.7.3 and 3.11).

#include <filesystem>
#include <optional>
#include <string>

#include "scene/assets/asset.h"
#include "scene/assets/gltf_container.h"

namespace scanmill {

// The file at the clip's time, or as its nodes stand where none is given: moving nodes are where they are then, meshes
// with a skin or morph targets have the positions of their vertices then, and skins, morph targets and animations are
// gone. Whoever calls has checked buffers, views, accessors and the tree of nodes (scene/assets/gltf.h); what else is
// wrong throws an InputError that names the file.
GltfContainer posedGltf(GltfContainer container, const std::filesystem::path& file,
                        const std::optional<ClipTime>& clip);

}  // namespace scanmill
