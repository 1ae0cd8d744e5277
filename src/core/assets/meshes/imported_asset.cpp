#include "assets/meshes/imported_asset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/assimp/reader.h"
#include "assets/meshes/child_process.h"
#include "assets/meshes/imported_file.h"
#include "base/error.h"
#include "base/memory.h"

namespace scanmill {

namespace {

// Memory limit of the child process (bytes) for an empty file. Each byte of the file adds 64 bytes to the limit.
constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;
constexpr unsigned kSeconds = 300;

ImportedFile importByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
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

Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options) {
  ImportedFile imported = kind == ".ply"   ? readPlyMesh(file, options)
                          : kind == ".obj" ? readObjMesh(file, options)
                          : kind == ".stl" ? readStlMesh(file, options)
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
