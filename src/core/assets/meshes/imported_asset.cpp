#include "assets/meshes/imported_asset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/assimp/reader.h"
#include "assets/meshes/child_process.h"
#include "assets/meshes/imported_file.h"
#include "assets/meshes/off_mesh.h"
#include "base/error.h"
#include "base/memory.h"
#include "config/file_kind.h"

namespace scanmill {

namespace {

// Memory limit of the child process (bytes) for an empty file. Each byte of the file adds 64 bytes to the limit.
constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;
constexpr unsigned kSeconds = 300;

// The kinds for which assimp is used. It reads more kinds, but loses without a word much of what these say, such as the
// units of 3MF, AMF, DXF and X3D.
constexpr std::array<std::string_view, 7> kByAssimp{".3ds", ".ac", ".ac3d", ".acc", ".dae", ".fbx", ".x"};

// Kinds of rasters that are not read, but that the programs of GDAL convert.
constexpr std::array<std::string_view, 16> kRasters{".adf", ".bil", ".bip", ".bsq", ".bt", ".ers", ".flt", ".gpkg",
                                                    ".grd", ".gtx", ".hdr", ".jp2", ".nc", ".pix", ".rst", ".sdat"};

ImportedFile importByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  if (std::find(kByAssimp.begin(), kByAssimp.end(), kind) == kByAssimp.end()) {
    if (isMap(file)) {
      throw InputError({file.string()},
                       "is a map of OpenStreetMap, from which an object `town: {map: ...}` of a scene "
                       "builds a town; docs/town.md says how");
    }
    if (std::find(kRasters.begin(), kRasters.end(), kind) != kRasters.end()) {
      throw InputError(
          {file.string()},
          fmt::format("has a kind of rasters that is not read ('{}'): convert it by `gdal_translate {} {}`{}", kind,
                      file.string(), std::filesystem::path(file).replace_extension(".tif").string(),
                      kind == ".hdr" ? ", with the file of the values in place of their header" : ""));
    }
    throw InputError(
        {file.string()},
        fmt::format("has an unknown kind ('{}'): {}convert it to glTF, GLB, OBJ, PLY, STL, DAE, FBX, AC or "
                    "BLEND, for example with Blender or FreeCAD",
                    kind,
                    kind == ".txt" ? "if it holds points, give it the ending .xyz, and a first line of "
                                     "names (x y z intensity ...) if it has more than x, y and z; else "
                                   : ""));
  }
  const std::uint64_t memory = std::min(kMemory + 64 * std::filesystem::file_size(file), memoryLimitBytes());
  try {
    return importedFrom(inChildProcess([&] { return bytesOf(readByAssimp(file, kind, options)); }, memory, kSeconds));
  } catch (const ChildEnded& e) {
    throw InputError({file.string()}, fmt::format("cannot be read: {}; {}", e.what(), remedyFor(kind)));
  } catch (const Error& e) {
    throw InputError({file.string()}, e.what());
  }
}

}  // namespace

bool isAc3d(const std::string& kind) {
  return kind == ".ac" || kind == ".acc" || kind == ".ac3d";
}

std::string remedyFor(const std::string& kind) {
  return isAc3d(kind) ? "remove objects without surfaces, or convert it to glTF or OBJ"
                      : "check that the file is complete, or convert it to glTF or OBJ";
}

Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  ImportedFile imported = kind == ".ply"   ? readPlyMesh(file, options)
                          : kind == ".obj" ? readObjMesh(file, options)
                          : kind == ".stl" ? readStlMesh(file, options)
                          : kind == ".off" ? readOffMesh(file, options)
                                           : importByAssimp(file, kind, options);
  if (!imported.missing.empty()) {
    warn(
        fmt::format("{}: names '{}', which is missing: its materials have the default "
                    "reflectance",
                    file.string(), fmt::join(imported.missing, "', '")));
  }
  if (!imported.problems.empty()) {
    warn(fmt::format("{}: may be incomplete, since the importer reports: {}", file.string(),
                     fmt::join(imported.problems, "; ")));
  }
  const std::vector<Look> looks = readMaterials(imported, file, options, imported.leftOut);
  Asset asset;
  asset.up = imported.up;
  asset.upDeclared = imported.upDeclared;
  asset.statedUnit = imported.statedUnit;
  asset.origin = imported.origin;
  asset.dropped.outOfRange = imported.outOfRange;
  asset.parts = std::move(imported.parts);
  for (AssetPart& part : asset.parts) {
    const bool known = part.materialIndex < looks.size();
    if (known) static_cast<Look&>(part) = looks[part.materialIndex];
    checkTexture(part, !known || imported.materials[part.materialIndex].base.repeats, imported.leftOut);
  }
  imported.leftOut.tell(file.string());
  return asset;
}

}  // namespace scanmill
