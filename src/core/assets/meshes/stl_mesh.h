#pragma once

// Reads STL files, in text and in binary form ("StereoLithography Interface Specification", 3D Systems, 1989). The
// keywords of the text may be in upper case. Each `solid` is a node; a binary file is one node without a name. A file
// is binary if its size is that of the number of triangles in its header, or if it does not begin with `solid`.

#include <filesystem>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"
#include "base/format_support.h"

namespace scanmill {

const FormatSupport& stlFormat();

// Reads the file. Throws InputError, with the line in a text, if it is truncated or is not an STL file.
ImportedFile readStlMesh(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
