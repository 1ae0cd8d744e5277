#include "assets/asset.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "assets/asset_kinds.h"
#include "assets/meshes/asset_parts.h"
#include "assets/meshes/blender.h"
#include "assets/meshes/gltf/reader.h"
#include "assets/meshes/imported_file.h"
#include "assets/surveys/surveys.h"
#include "assets/worlds/world_asset.h"
#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "base/memory.h"
#include "config/text.h"
#include "formats/cloud_file.h"

namespace scanmill {

namespace {

// Throws InputError if the file is absent or empty, or if an option does not fit the file. In this source file, `kind`
// is the ending of a file's name in lower case.
void checkRequest(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  const auto fail = [&](const std::string& problem) { throw InputError({file.string()}, problem); };
  if (options.clip && kind != ".gltf" && kind != ".glb") {
    fail("is not glTF: animations are read only from .gltf and .glb, so convert the file");
  }
  if (!pathExists(file)) fail("the file does not exist");
  if (!isFile(file)) fail("is not a file");
  if (std::filesystem::file_size(file) == 0) fail("is empty");
}

// Reads the glTF file `glb`, in metres. Messages call the file `name`. `up`: the up axis of the file; the options can
// override it.
Asset readGltf(const std::filesystem::path& glb, const std::filesystem::path& name, char up,
               const AssetOptions& options) {
  up = options.up.value_or(up);
  Asset asset = gltf::readAsset(glb, name, {assetFromFile(up, options.metresPerUnit), {}}, options);
  asset.up = up;
  asset.upDeclared = true;
  asset.statedUnit = 1;
  return asset;
}

// Lets Blender convert the file to a GLB whose up axis is z, and reads this GLB.
Asset readByBlender(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  if (kind != ".blend" && options.up) {
    throw InputError({file.string()},
                     "is turned upright by Blender: leave out `up`, and turn the object where it is placed");
  }
  const FilesRead temporary;  // keeps the exported temporary file out of the list of files read
  const ScratchFolder folder;
  Asset asset = readGltf(exportByBlender(file, folder.path()), file, 'z', options);
  if (kind == ".abc") asset.statedUnit = 0;  // Alembic states no unit
  return asset;
}

// Warns if the greatest coordinate of an asset exceeds both the asset's extent and kFar, beyond which float32 is
// coarse.
void warnOfCoarseCoordinates(const Asset& asset, const std::filesystem::path& file) {
  constexpr double kFar = 16384;  // m; from here on, steps of float32 are about 2 mm or more
  Box box;
  for (const AssetPart& part : asset.parts) {
    for (const Vec3f& p : part.positions) {
      if (isFinite(p)) box.add(Vec3d(p));
    }
  }
  if (box.empty()) return;
  double farthest = 0, extent = 0;
  for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    farthest = std::max({farthest, std::abs(box.low.*axis), std::abs(box.high.*axis)});
    extent = std::max(extent, box.high.*axis - box.low.*axis);
  }
  if (farthest < kFar || extent > farthest) return;
  const auto coordinate = static_cast<float>(farthest);
  const float step = std::nextafter(coordinate, std::numeric_limits<float>::infinity()) - coordinate;
  warn(
      "{}: its coordinates reach {:.0f} m, where single precision, in which this kind of file is read, has "
      "steps of {:.2g} m: subtract an offset from all coordinates and give it as the object's `position`, "
      "or convert the file to a binary PLY of triangles with coordinates in double",
      file.string(), farthest, static_cast<double>(step));
}

// Reads the file by the reader of its kind. Throws InputError if it has no triangles.
Asset readByKind(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  if (isCloud(file)) return readCloudAsset(file, options);
  const AssetReader reader = readerOf(file);
  if (reader == AssetReader::Heights) return readHeightAsset(file, options);
  if (reader == AssetReader::None) throw InputError({file.string()}, whyNoReader(file));
  Asset asset = reader == AssetReader::World     ? readWorld(file, kind, options)
                : reader == AssetReader::Mesh    ? readImported(file, kind, options)
                : reader == AssetReader::Blender ? readByBlender(file, kind, options)
                                                 : readGltf(file, file, 'y', options);
  if (asset.parts.empty() && asset.instanced.empty()) {
    throw InputError({file.string()}, "has no triangle{}",
                     asset.dropped.outOfRange > 0 ? " whose indices are in range: the file is damaged"
                                                  : ": points alone are read from PLY, PCD, LAS and .xyz files");
  }
  warnOfCoarseCoordinates(asset, file);
  returnFreedMemoryIfScarce();  // the importer allocates every face separately, 60 MiB for a million triangles
  return asset;
}

}  // namespace

Asset readAsset(const std::filesystem::path& file, const AssetOptions& options) {
  const InputBudget budget;
  const std::string kind = lowerExtension(file);
  checkRequest(file, kind, options);
  recordFile(file);
  try {
    Asset asset = readByKind(file, kind, options);
    asset.file = file;
    return asset;
  } catch (const InputLimitError&) {
    throw;
  } catch (const InputError& e) {
    const std::string content = otherContent(file);
    if (content.empty() || std::string_view(e.what()).find(content) != std::string_view::npos) throw;
    throw InputError(fmt::format("{}; its first bytes look like {}", e.what(), content));
  }
}

}  // namespace scanmill
