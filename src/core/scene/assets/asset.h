#pragma once

// Reads a 3D file: glTF/GLB, OBJ, PLY, STL, COLLADA, FBX, AC3D, what else assimp knows, .blend where Blender is
// installed, and descriptions of worlds (SDF, URDF, 3D Tiles) with all that they name.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace scanmill {

// Triangles that share a node and a material, in the asset's frame after the conversion of units and axes: metres, z
// up.
struct AssetPart {
  std::string node;  // name of the node that holds it, or of its nearest ancestor with one; "" where the file has none
  std::uint32_t nodeIndex = 0;  // parts of one node share it; nodes count in file order (depth first)
  std::string material;         // name in the file
  std::string texture;  // base colour file as the asset names it (decoded, such as "textures/leaf.png"), or empty
  Material
      fileMaterial;  // from the file: name, texture, roughness, metallic, alpha; reflectance from base colour luminance
  std::array<float, 3> color{1, 1, 1};  // linear; the base colour where there is no texture, else what multiplies it
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;  // empty, or one per position; v = 0 is the image's bottom row
  std::vector<Triangle> triangles;
};

// Whether beams pass where a base colour's alpha is low.
enum class AlphaUse {
  // As the file says. glTF: alphaMode MASK (at alphaCutoff) and BLEND (at 0.5). Other kinds: at 0.5, where a material
  // has an opacity map or an opacity between 0 and 1 (MTL map_d, d and Tr; COLLADA transparent; FBX TransparentColor;
  // AC3D trans). Many files declare nothing and mean cut-outs (leaves) or something else altogether (which parts of a
  // car take the paint); their alpha counts if it looks like cut-outs: see isCutOut() in scene/assets/asset_alpha.h.
  Auto,
  Ignore,  // everything is solid
  Test,    // at 0.5, or at the cutoff that the file gives
};

// A moment of an animation of a glTF file.
struct ClipTime {
  std::string clip;  // its name, or its number from 0
  double time = 0;   // s, of its key frames; before the first and after the last as at those
};

struct AssetOptions {
  // How many metres a unit of the file is. For the kinds that declare their unit (COLLADA, FBX) it multiplies the
  // declared one, as the scale of an SDF does.
  double metresPerUnit = 1.0;
  // The up axis of the file's coordinates, 'x', 'y' or 'z': (x, y, z) becomes (x, -z, y) from y-up and (-y, -z, x) from
  // x-up. It replaces what the file declares. Without one, the file decides: COLLADA by up_axis and FBX by UpAxis (y
  // where there is none); glTF and AC3D are y-up by their specifications, .blend is z-up; OBJ, PLY, STL and the rest,
  // which cannot say, are taken as z-up.
  std::optional<char> up = std::nullopt;
  AlphaUse alpha = AlphaUse::Auto;
  bool textures = true;                         // false: only textures with alpha are loaded
  std::optional<ClipTime> clip = std::nullopt;  // of glTF and GLB alone: as all stands then
};

// Parts that the file itself places several times: by EXT_mesh_gpu_instancing of glTF, or models of a world.
struct InstancedParts {
  std::vector<AssetPart> parts;  // in a frame of their own
  std::vector<Affine> assetFromParts;
};

struct Asset {
  std::filesystem::path file;
  char up = 'z';            // the up axis of the file's coordinates: AssetOptions::up, or else what the file says
  bool upDeclared = false;  // the file or its kind says which axis is up
  std::vector<AssetPart> parts;
  std::vector<InstancedParts> instanced;
  Dropped dropped;  // triangles with indices out of range are dropped here; the rest is left to clean()
};

// Reads the file. Throws an InputError that names it and says what is wrong: it is absent, empty, truncated, of an
// unknown kind, or has no triangles. A missing texture is a warning, and its material has a plain colour instead. Lines
// and points are left out without a word.
Asset readAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
