#pragma once

// Reads 3D files: point clouds (LAS, PLY, PCD), height rasters (GeoTIFF), glTF/GLB, OBJ, PLY, STL, COLLADA, AC3D,
// .blend and what Blender imports (FBX, Alembic, X3D, USD) if it is installed, and world descriptions (SDF, URDF, 3D
// Tiles) with all files that they name.

#include <filesystem>

#include "assets/meshes/asset_data.h"

namespace scanmill {

// Reads the file. Throws an InputError that names the file and the problem: it is absent, empty, truncated, of an
// unknown kind, or has no triangles. If a texture is missing, warns and gives its material a plain colour. Warns once
// of what the file holds besides, such as lines and points, with counts.
Asset readAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
