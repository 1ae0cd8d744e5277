#pragma once

// The contents of a mesh file as its reader returns them: plain data, which a child process can send to its parent.
// Also declares the readers of OBJ, PLY and STL, and the readers of COLLADA and AC3D, which use assimp.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "base/format_support.h"

namespace scanmill {

// How texture coordinates are placed on an image.
struct UvPlacement {
  std::uint32_t channel = 0;  // index of the set of texture coordinates, if there are several
  Vec2f scale{1, 1}, offset{0, 0};

  Vec2f apply(const Vec2f& uv) const { return {uv.x * scale.x + offset.x, uv.y * scale.y + offset.y}; }
  bool operator==(const UvPlacement&) const = default;
};

// A reference of a material to an image.
struct ImportedMap {
  std::string name;  // name of the image in the file; empty: none
  bool inverted = false;
  bool repeats = true;  // false: the file clamps or mirrors the image outside of 0 to 1
  UvPlacement placement = {};
};

struct ImportedMaterial {
  std::string name;
  bool stated = true;  // false: parts have this material because the file states none
  float roughness = 1, metallic = 0, opacity = 1;
  std::array<float, 3> color{1, 1, 1};  // base colour, linear RGB
  ImportedMap base;                     // image of the base colour
  ImportedMap opacityMap;

  bool namesImages() const { return !base.name.empty() || !opacityMap.name.empty(); }
  // Returns the placement of both images: the base colour's or, if there is no base colour image, the opacity map's.
  const UvPlacement& placement() const { return base.name.empty() ? opacityMap.placement : base.placement; }
};

// An asset whose parts have no looks yet: readMaterials() makes looks from `materials`.
struct ImportedFile : Asset {
  std::vector<ImportedMaterial> materials;
  std::vector<std::string> missing;   // missing material libraries, as the file names them
  std::vector<std::string> problems;  // errors in the file that the importer reported and ignored
  LeftOut leftOut;
};

// Readers of mesh files; `scanmill list inputs` lists their formats. `file` must exist. Triangles with indices out of
// range are dropped and counted. The readers throw InputError, with the line of text files, for contents that they
// cannot read, and for a file outside of the asset's folder unless AssetOptions::allowOutside is set.
extern const FormatSupport kObjFormat;
extern const FormatSupport kPlyMeshFormat;
extern const FormatSupport kStlFormat;
extern const FormatSupport kColladaFormat;
extern const FormatSupport kAc3dFormat;
ImportedFile readObjMesh(const std::filesystem::path& file, const AssetOptions& options);
ImportedFile readPlyMesh(const std::filesystem::path& file, const AssetOptions& options);
ImportedFile readStlMesh(const std::filesystem::path& file, const AssetOptions& options);

// Reads a file of any of these kinds as readAsset() does, but also accepts a file without triangles. `kind` is its
// extension in lower case. The assimp library, which is made for trusted files, runs in a child process.
Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

// Returns the looks of the imported file's materials, in the file's order. Warns of missing and broken textures. Throws
// InputError for a texture outside of the file's folder, unless AssetOptions::allowOutside is set. Adds what is not
// modelled to ImportedFile::leftOut.
std::vector<Look> readMaterials(ImportedFile& imported, const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
