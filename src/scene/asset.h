#pragma once

// Reads a 3D file: glTF/GLB, OBJ, PLY, STL, COLLADA, FBX, AC3D and what else assimp knows.

#include <filesystem>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace scanmill {

// Triangles that share a node and a material, in the asset's frame after unit and axis conversion: metres, z up.
struct AssetPart {
  std::string node;  // name of the node that holds it, or of its nearest ancestor with one; "" where the file has none
  std::uint32_t nodeIndex = 0;  // parts of one node share it; nodes count in file order (depth first)
  std::string material;         // name in the file
  std::string texture;  // base colour file as the asset names it (decoded, such as "textures/leaf.png"), or empty
  Material look;  // from the file: name, texture, roughness, metallic, alpha; reflectance from base colour luminance
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;  // empty, or one per position; v = 0 is the image's bottom row
  std::vector<Triangle> triangles;
};

struct AssetOptions {
  // For kinds that declare their unit (COLLADA, FBX) it counts on top of the declared one, as the scale of an SDF does.
  double metresPerUnit = 1.0;
  // The file's up axis, 'x', 'y' or 'z': (x, y, z) becomes (x, -z, y) from y-up and (-y, -z, x) from x-up.
  // COLLADA and FBX declare theirs: 'z' leaves it to the declaration, 'x' and 'y' replace it.
  char up = 'z';
  bool textures = true;  // false: only textures with alpha are loaded
};

struct Asset {
  std::filesystem::path file;
  std::vector<AssetPart> parts;
  Dropped dropped;  // triangles with indices out of range are dropped here; the rest is left to clean()
};

// Throws InputError that names the file and what is wrong (absent, empty, truncated, no triangles, unknown kind).
// Missing textures are one warning each and leave the material's plain colour. Lines and points are left out silently.
// `glTF` is always y-up and in metres by its specification: readAsset honours that where the caller passes up = 'y'.
Asset readAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
