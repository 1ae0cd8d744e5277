#pragma once

// An asset in memory: the parts of a 3D file as meshes with materials; and the options with which it is read.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace scanmill {

// The appearance of a surface, as the file states it.
struct Look {
  std::string material;   // name of the material in the file
  std::string texture;    // base colour image as the file names it ("textures/leaf.png", without URI escapes), or empty
  Material fileMaterial;  // material in the file; reflectance: luminance of the base colour, or a default
  std::array<float, 3> color{1, 1, 1};  // base colour, or the factor on the texture; linear
};

// Triangles that share a node and a material, in the asset's frame: metres, z up (after the conversion of units and
// axes).
struct AssetPart : Look {
  std::string node;             // name of its node, or of the nearest ancestor with a name; "" if no ancestor has one
  std::uint32_t nodeIndex = 0;  // the node's number in file order (depth first); parts of the same node share it
  std::uint32_t materialIndex = 0;  // number of the material in the file, from which the look is made
  std::vector<Vec3f> positions;
  std::vector<Vec2f> uvs;  // empty, or one per position; v = 0 is the image's bottom row
  std::vector<Triangle> triangles;
  std::string ownClass;  // class that the file states, as labelled point clouds do; empty: none
};

// How the alpha of a base colour decides whether beams pass through a surface.
enum class AlphaUse {
  // Beams pass where the file declares transparency. glTF: where alpha is below alphaCutoff (alphaMode MASK) or 0.5
  // (BLEND). Other kinds: where alpha is below 0.5, if the material has an opacity map or an opacity between 0 and 1
  // (MTL map_d, d and Tr; COLLADA transparent; AC3D trans). Many files of these other kinds declare nothing, and their
  // alpha can mean cut-outs (leaves) or, for example, the painted parts of a car. Beams then pass where alpha is below
  // 0.5 if the alpha looks like that of cut-outs: see isCutOut() in assets/meshes/base_color.cpp.
  Auto,
  Ignore,  // beams never pass, whatever the alpha
  Test,    // beams pass where alpha is below 0.5, or below the cutoff in the file
};

// A time in an animation of a glTF file.
struct ClipTime {
  std::string clip;  // name of the animation, or its number, counted from 0
  double time = 0;   // s, in the time of the key frames; clamped to the first and last key frame
  bool operator==(const ClipTime&) const = default;
};

// How the points of a cloud are turned into discs: see assets/surveys/surveys.h.
struct SurfelOptions {
  double cover = 1.5;                        // factor on the radius of a disc with the area that the point represents
  std::array<double, 2> radius{0.005, 0.2};  // m, least and greatest radius
  bool operator==(const SurfelOptions&) const = default;
};

// How a point cloud is turned into surfaces.
struct PointOptions {
  enum class Reflectance { Auto, Intensity, Color, None };
  double spacing = 0;  // m, edge of grid cubes, in each of which one point is kept; 0: all points are kept
  SurfelOptions surfels = {};
  Reflectance reflectance = Reflectance::Auto;       // Auto: from intensities if the file has them, else from colours
  double full = 0;                                   // intensity that means a reflectance of 1; 0: it is guessed
                                                     // from the greatest intensities
  std::map<std::uint32_t, std::string> labels = {};  // class names by label; empty: names from the file format, if it
                                                     // has them
  bool operator==(const PointOptions&) const = default;
};

// The part of a height raster that is read, and the classes and colours of its surface.
struct HeightOptions {
  int every = 1;  // a square of `every` x `every` samples becomes one sample
  // Least x, least y, greatest x, greatest y, in the raster's coordinates.
  std::optional<std::array<double, 4>> within = std::nullopt;
  std::filesystem::path classes = {};  // a raster of class numbers; empty: none
  std::filesystem::path image = {};    // a raster of colours; empty: none
  bool operator==(const HeightOptions&) const = default;
};

struct AssetOptions {
  // Metres per unit of the file. If the file declares its unit (COLLADA, files that Blender imports), this is a factor
  // on the declared unit, like the <scale> of a mesh in SDF.
  double metresPerUnit = 1.0;
  bool unitStated = false;  // true: units that LAS files state are ignored
  // The up axis of the file's coordinates, 'x', 'y' or 'z': (x, y, z) becomes (x, -z, y) from y-up and (-y, -z, x) from
  // x-up. It overrides the axis that the file declares. If not set, the file decides: COLLADA by up_axis (y if absent);
  // glTF and AC3D are y-up by their specifications, .blend is z-up; OBJ, PLY and STL, which cannot declare an axis,
  // count as z-up. Must not be set for files that Blender imports, since Blender turns them upright.
  std::optional<char> up = std::nullopt;
  AlphaUse alpha = AlphaUse::Auto;
  bool textures = true;                         // false: only textures with alpha are loaded, for alpha tests
  std::optional<ClipTime> clip = std::nullopt;  // animation time to load (only glTF and GLB)
  // True: files that an asset names may be outside of its folder. False: such names are refused.
  bool allowOutside = false;
  bool leaveOutMissing = false;               // true: models, meshes and tiles that a world names may be missing
  std::map<std::string, double> joints = {};  // positions of joints of a URDF (rad or m), by their names; others: 0
  std::vector<std::filesystem::path> textureFolders = {};  // searched last for images that are missing at their paths
  PointOptions points = {};                                // options for point clouds
  HeightOptions heights = {};                              // options for height rasters
  bool operator==(const AssetOptions&) const = default;
};

// Parts that the file places several times: once by each transform in `assetFromParts`. They come from glTF's
// EXT_mesh_gpu_instancing or are models of a world.
struct InstancedParts {
  std::vector<AssetPart> parts;  // in their own frame; see assetFromParts
  std::vector<Affine> assetFromParts;
};

struct Asset {
  std::filesystem::path file;
  char up = 'z';            // up axis of the file's coordinates: AssetOptions::up if set, else the file's axis
  bool upDeclared = false;  // true if the file or its kind states the up axis
  double statedUnit = 0;    // metres per unit, as the file or its kind states it; 0: not stated
  std::vector<AssetPart> parts;
  Vec3d origin;  // m, asset frame; `parts` are relative to it; zero unless coordinates are too large for float32
  std::vector<InstancedParts> instanced;
  std::string system;      // coordinate system of x and y in `parts`, if this is a survey (in m); empty: not stated
  bool ownMiddle = false;  // true: the file is in degrees or earth-centred; x and y are relative to its middle, whose
                           // coordinates `system` states
  Dropped dropped;         // triangles with indices out of range; clean() drops other broken triangles
};

}  // namespace scanmill
