#pragma once

// Reads a 3D file: clouds of points (LAS, PLY, PCD), rasters of heights (GeoTIFF), glTF/GLB, OBJ, PLY, STL, COLLADA,
// FBX, AC3D, what else assimp knows, .blend where Blender is installed, and descriptions of worlds (SDF, URDF, 3D
// Tiles) with all that they name.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
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
  std::string ownClass;  // that the file itself gives it, as in a labelled cloud of points; empty: none
};

// Whether beams pass where a base colour's alpha is low.
enum class AlphaUse {
  // As the file says. glTF: alphaMode MASK (at alphaCutoff) and BLEND (at 0.5). Other kinds: at 0.5, where a material
  // has an opacity map or an opacity between 0 and 1 (MTL map_d, d and Tr; COLLADA transparent; FBX TransparentColor;
  // AC3D trans). Many files declare nothing and mean cut-outs (leaves) or something else altogether (which parts of a
  // car take the paint); their alpha counts if it looks like cut-outs: see isCutOut() in assets/asset_alpha.h.
  Auto,
  Ignore,  // everything is solid
  Test,    // at 0.5, or at the cutoff that the file gives
};

// A moment of an animation of a glTF file.
struct ClipTime {
  std::string clip;  // its name, or its number from 0
  double time = 0;   // s, of its key frames; before the first and after the last as at those
};

// How the points of a cloud become discs: see assets/surveys/surfels.h.
struct SurfelOptions {
  int neighbors = 12;                        // points from which normal and radius are estimated, 3 to 100
  double cover = 1.5;                        // times the radius of a disc whose area is a point's share of the surface
  std::array<double, 2> radius{0.005, 0.2};  // m, least and most
};

// How a cloud of points becomes surfaces.
struct PointOptions {
  enum class Reflectance { Auto, Intensity, Color, None };
  double spacing = 0;  // m, of a grid of cubes, one point in each; 0: all points
  SurfelOptions surfels = {};
  Reflectance reflectance = Reflectance::Auto;       // from intensities where there are any, else from colours
  double full = 0;                                   // the intensity of a reflectance of 1; 0: by the greatest one
  std::map<std::uint32_t, std::string> labels = {};  // what labels mean; empty: as the kind of file says, if it does
};

// What of a raster of heights is taken, and what lies on it.
struct HeightOptions {
  int every = 1;  // so many samples along each axis become one
  std::optional<std::array<double, 4>> within =
      std::nullopt;                    // least and greatest x and y, in the raster's coordinates
  std::filesystem::path classes = {};  // a raster of numbers of classes; empty: none
  std::filesystem::path image = {};    // a raster of colours; empty: none
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
  // Files that a glTF or OBJ names may lie outside of its folder; else such a name is refused.
  bool allowOutside = false;
  PointOptions points = {};    // of clouds of points
  HeightOptions heights = {};  // of rasters of heights
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
  Vec3d origin;  // m: where their frame lies in the asset's; not zero where coordinates are too large for float32
  std::vector<InstancedParts> instanced;
  Dropped dropped;  // triangles with indices out of range are dropped here; the rest is left to clean()
};

// Reads the file. Throws an InputError that names it and says what is wrong: it is absent, empty, truncated, of an
// unknown kind, or has no triangles. A missing texture is a warning, and its material has a plain colour instead. Lines
// and points are left out without a word.
Asset readAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
