#pragma once

// Reads PLY files of meshes: text and binary, polygons of any number of corners.
//
//   element vertex     x y z; s t, u v or texture_u texture_v: texture coordinates
//   element face       vertex_indices or vertex_index; texcoord: texture coordinates of its corners; texnumber: index
//   of
//                      its image; material_index: index of its material
//   element material   diffuse_red, diffuse_green, diffuse_blue
//   comment TextureFile NAME    an image, as MeshLab writes it
//
// The properties may have any type. Large coordinates in double or text keep their precision: see ImportedFile::origin.

#include <filesystem>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"
#include "base/format_support.h"

namespace scanmill {

// Returns the table of the elements and properties that the reader knows.
const FormatSupport& plyMeshFormat();

// Reads the file. Triangles with indices out of range are dropped and counted. Throws InputError, with the line of text
// files, if the file lacks anything that its header announces.
ImportedFile readPlyMesh(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
