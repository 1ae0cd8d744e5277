#pragma once

// Reads Wavefront OBJ files: the polygons of "Appendix B1. Object Files (.obj)" of the Advanced Visualizer's manual.
// Coordinates are read in double precision.
//
//   v x y z [w] [r g b [a]]    a vertex; its weight and its colour are not used
//   vt u [v [w]]               texture coordinates
//   f v[/vt][/vn] ...          a polygon; negative indices count from the latest vertex
//   o NAME, g NAME             the node of the faces that follow: the group if there is one, else the object. Names may
//                              contain spaces. Faces of one object and group are one node, even if others come between.
//   usemtl NAME, mtllib FILE   materials; the name of a library may contain spaces, and a line may name several
//
// Statements that the table objFormat() leaves out, such as lines, and unknown ones are counted in one warning.

#include <filesystem>
#include <string>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"
#include "base/format_support.h"

namespace scanmill {

const FormatSupport& objFormat();

// Reads the file. Triangles with indices out of range are dropped and counted. Throws InputError with the line of a
// statement that cannot be read, and for a library outside of the asset's folder unless AssetOptions::allowOutside.
ImportedFile readObjMesh(const std::filesystem::path& file, const AssetOptions& options);

// Reads the text of a file as readObjMesh() does. Messages name the file.
ImportedFile readObjText(std::string text, const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
