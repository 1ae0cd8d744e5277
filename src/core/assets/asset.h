#pragma once

// Reads 3D files: point clouds (LAS, PLY, PCD), height rasters (GeoTIFF), glTF/GLB, OBJ, PLY, STL, COLLADA, FBX, AC3D,
// the other kinds that assimp reads, .blend if Blender is installed, and world descriptions (SDF, URDF, 3D Tiles) with
// all files that they name.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace scanmill {

// Triangles that share a node and a material, in the asset's frame: metres, z up (after the conversion of units and
// axes).
struct AssetPart {
  std::string node;  // name of its node, or of the node's nearest ancestor that has a name; "" if there is none
  std::uint32_t nodeIndex = 0;  // number of its node in file order (depth first); parts of a node share it
  std::string material;         // name in the file
  std::string texture;  // base colour file as the asset names it (decoded, such as "textures/leaf.png"), or empty
  Material
      fileMaterial;  // from the file: name, texture, roughness, metallic, alpha; reflectance from base colour luminance
  std::array<float, 3> color{1, 1, 1};  // linear; the base colour, or the factor on the texture if there is one
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;  // empty, or one per position; v = 0 is the image's bottom row
  std::vector<Triangle> triangles;
  std::string ownClass;  // class that the file itself states, as a labelled point cloud does; empty: none
};

// How the alpha of a base colour decides whether beams pass through a surface.
enum class AlphaUse {
  // Follows the declaration of the file. glTF: beams pass below alphaCutoff for alphaMode MASK, and below 0.5 for
  // BLEND. Other kinds: below 0.5, if a material has an opacity map or an opacity between 0 and 1 (MTL map_d, d and Tr;
  // COLLADA transparent; FBX TransparentColor; AC3D trans). Many files declare nothing, and their alpha can mean
  // cut-outs (leaves) or something else (which parts of a car take the paint). Such an alpha is used if it looks like
  // cut-outs: see isCutOut() in assets/asset_alpha.h.
  Auto,
  Ignore,  // beams never pass
  Test,    // beams pass below 0.5, or below the cutoff that the file states
};

// A time of an animation of a glTF file.
struct ClipTime {
  std::string clip;  // name of the animation, or its number, counted from 0
  double time = 0;   // s, as its key frames count it; clamped to the first and the last of them
};

// How the points of a cloud are turned into discs: see assets/surveys/surfels.h.
struct SurfelOptions {
  int neighbors = 12;  // number of points from which normal and radius are estimated, 3 to 100
  double cover = 1.5;  // factor on the radius of a disc as large as a point's share of the surface
  std::array<double, 2> radius{0.005, 0.2};  // m, limits: least, greatest
};

// How a point cloud is turned into surfaces.
struct PointOptions {
  enum class Reflectance { Auto, Intensity, Color, None };
  double spacing = 0;  // m, edge of grid cubes that keep one point each; 0: all points
  SurfelOptions surfels = {};
  Reflectance reflectance = Reflectance::Auto;       // Auto: from intensities if there are any, else colours
  double full = 0;                                   // intensity of a reflectance of 1; 0: from the greatest one
  std::map<std::uint32_t, std::string> labels = {};  // label -> class name; empty: names of the file format, if any
};

// The part of a height raster that is read, and the classes and colours of its surface.
struct HeightOptions {
  int every = 1;  // this many samples along each axis become one
  std::optional<std::array<double, 4>> within =
      std::nullopt;                    // least x and y, greatest x and y, in the raster's coordinates
  std::filesystem::path classes = {};  // a raster of class numbers; empty: none
  std::filesystem::path image = {};    // a raster of colours; empty: none
};

struct AssetOptions {
  // Metres per unit of the file. If the file declares its unit (COLLADA, FBX), this is a factor on the declared unit,
  // like the <scale> of a mesh in SDF.
  double metresPerUnit = 1.0;
  // The up axis of the file's coordinates, 'x', 'y' or 'z': (x, y, z) becomes (x, -z, y) from y-up and (-y, -z, x) from
  // x-up. It overrides the axis that the file declares. If not set, the file decides: COLLADA by up_axis and FBX by
  // UpAxis (y if absent); glTF and AC3D are y-up by their specifications, .blend is z-up; OBJ, PLY, STL and the other
  // kinds, which cannot declare an axis, count as z-up.
  std::optional<char> up = std::nullopt;
  AlphaUse alpha = AlphaUse::Auto;
  bool textures = true;                         // false: only textures with alpha are loaded
  std::optional<ClipTime> clip = std::nullopt;  // glTF and GLB only: the animation time to load
  // True: files that an asset names may be outside of its folder. False: such names are refused.
  bool allowOutside = false;
  PointOptions points = {};    // for point clouds
  HeightOptions heights = {};  // for height rasters
};

// Parts that the file itself places several times: by EXT_mesh_gpu_instancing of glTF, or as models of a world.
struct InstancedParts {
  std::vector<AssetPart> parts;  // in a frame of their own
  std::vector<Affine> assetFromParts;
};

struct Asset {
  std::filesystem::path file;
  char up = 'z';            // the up axis of the file's coordinates: AssetOptions::up if set, else the file's
  bool upDeclared = false;  // the file or its kind says which axis is up
  std::vector<AssetPart> parts;
  Vec3d origin;  // m: origin of the frame of `parts` in the asset's; not zero if coordinates are too large for float32
  std::vector<InstancedParts> instanced;
  Dropped dropped;  // triangles with indices out of range; clean() drops all other broken ones
};

// Reads the file. Throws an InputError that names the file and the problem: it is absent, empty, truncated, of an
// unknown kind, or has no triangles. A missing texture is a warning, and its material has a plain colour instead. Lines
// and points of meshes are skipped without a warning.
Asset readAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
