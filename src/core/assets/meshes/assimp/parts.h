#pragma once

// The parts of the reader that uses the assimp library (assets/meshes/assimp/reader.h).

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "assets/meshes/imported_file.h"

struct aiBone;
struct aiMesh;
struct aiScene;

namespace scanmill {

// Returns the text of an AC3D file (AC3Db or AC3Dc) as assimp reads it, and counts what is left out:
// - at most one texture per object. Racing games write several. The texture with the role `base`, or else the first
//   texture, is the colour and is kept; the others are shading and skid marks;
// - the transform of an object (`rot`, `loc`) in a group around the object and its kids, because assimp shifts surfaces
//   before it rotates them, and does not shift kids.
// Throws an Error that states the problem if the file has materials that assimp does not read.
std::string readAc3d(const std::filesystem::path& file, LeftOut& leftOut);

// The name of the material of surfaces that have none, as assimp calls it.
inline constexpr const char* kDefaultMaterial = "DefaultMaterial";

// A material of COLLADA, as its effect states it.
struct ColladaMaterial {
  bool colored = false;                // true: `diffuse` is a colour or an image
  bool clamps = false;                 // true: a sampler clamps or mirrors its image
  bool inverted = false;               // true: beams pass where the image of `transparent` is bright or opaque
  std::optional<double> transparency;  // the number of `transparency`, if `transparent` is an image
};

// What a COLLADA file (.dae; COLLADA 1.4.1 and 1.5) states and assimp does not report.
struct ColladaFacts {
  char up = 'y';                             // axis of `up_axis`
  double unit = 0;                           // metres per unit; 0: not stated
  std::map<std::string, std::string> names;  // of nodes, by their ids in `text`; empty: the node has none
  std::vector<ColladaMaterial> materials;    // those of `text` that have an effect, sorted by their ids, as by assimp
  LeftOut leftOut;
  // The file for assimp, in UTF-8: every node has an id, hidden nodes show nothing, and surfaces without a material
  // have kDefaultMaterial.
  std::string text;
};

// Throws an Error that states the problem and the line if the file is not XML, has elements that assimp reads wrong, or
// copies a node into itself.
ColladaFacts colladaFacts(const std::filesystem::path& file);

// How a material's image is placed by texture coordinates: scaled and shifted, in this order.
struct UvPlacement {
  std::uint32_t channel = 0;  // index of the set of texture coordinates
  Vec2f scale{1, 1}, offset{0, 0};
};

// Returns the materials of an assimp scene. Base colours count as linear, since most exporters write linear ones.
// `placements` receives one entry per material. Counts rotations of images, which are not applied.
std::vector<ImportedMaterial> materialsOf(const aiScene& scene, std::vector<UvPlacement>& placements, LeftOut& leftOut);

// Collects the errors that the assimp library meets in files and reads past, as long as the object lives.
struct ImporterLog {
  ImporterLog();
  ~ImporterLog();
  ImporterLog(const ImporterLog&) = delete;
  ImporterLog& operator=(const ImporterLog&) = delete;
  std::vector<std::string> problems;  // the first ones
};

// The vertices of a mesh with a skin, in the asset's frame.
struct SkinnedMesh {
  std::vector<Vec3d> vertices;
  bool mirrored = false;  // true: the joints' transforms mirror
};

// Returns the vertices of a mesh where its joints take them, each by the mean of their transforms, weighted (linear
// blend skinning). `assetFromMesh` returns a joint's transform; nullopt if the file has no node for it, which `leftOut`
// then counts. Vertices without such a joint follow the mesh's node. Returns nullopt if the mesh has no skin, or if all
// joints take it where its node does.
std::optional<SkinnedMesh> skinned(const aiMesh& mesh, const Affine& assetFromNode,
                                   const std::function<std::optional<Affine>(const aiBone&)>& assetFromMesh,
                                   LeftOut& leftOut);

}  // namespace scanmill
