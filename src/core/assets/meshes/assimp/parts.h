#pragma once

// Reads COLLADA and AC3D with the assimp library. Damaged files can crash the library or make it use much time and
// memory, so readImported() calls it in a child process.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "assets/meshes/imported_file.h"

namespace scanmill {

// Reads a file. `kind` is the file's extension in lower case: ".dae" or an extension of AC3D files. Throws an Error
// that states the problem, but not the file's name.
ImportedFile readByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

// Returns advice for messages about a file of this kind that cannot be read.
std::string remedyFor(const std::string& kind);

// Reads an AC3D file (AC3Db or AC3Dc), counts what is left out, and returns the text, changed for assimp:
// - at most one texture per object. Racing games write several. The texture with the role `base`, or else the first
//   texture, is the colour and is kept; the others are shading and skid marks;
// - the transform of an object (`rot`, `loc`) in a group around the object and its kids: assimp would shift surfaces
//   before it rotates them, and would not shift kids.
// Throws an Error that states the problem if the file has materials that assimp does not read.
std::string readAc3d(const std::filesystem::path& file, LeftOut& leftOut);

// The name that assimp gives to the material of surfaces without a material.
inline constexpr const char* kDefaultMaterial = "DefaultMaterial";

// A material of COLLADA, as its effect states it.
struct ColladaMaterial {
  bool colored = false;                // true: `diffuse` is a colour or an image
  bool clamps = false;                 // true: a sampler clamps or mirrors its image
  bool inverted = false;               // true: beams pass where the image of `transparent` is bright or opaque
  std::optional<double> transparency;  // value of <transparency>, if `transparent` is an image
};

// Facts of a COLLADA file (.dae; COLLADA 1.4.1 and 1.5) that assimp does not report.
struct ColladaFacts {
  char up = 'y';                           // up axis, from <up_axis>
  double unit = 0;                         // metres per unit; 0: not stated
  std::vector<ColladaMaterial> materials;  // materials with an effect, sorted by id, as assimp sorts them
};

// Reads the facts of a COLLADA file, counts what is left out, and returns the file for assimp, in UTF-8: nodes without
// a name are named by their ids, hidden nodes are empty, and surfaces without a material have kDefaultMaterial. Throws
// an Error with the problem and its line if the file is not XML, has elements that assimp reads wrong, or copies a node
// into itself.
std::string readCollada(const std::filesystem::path& file, ColladaFacts& facts, LeftOut& leftOut);

}  // namespace scanmill
