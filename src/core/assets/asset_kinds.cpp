#include "assets/asset_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "base/text_scan.h"
#include "config/resources.h"
#include "config/text.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

enum class InFolders {
  Listed,  // always a mesh, cloud or world: returned by assetsIn()
  Warned,  // not returned by assetsIn(), which warns of them
  Ignored  // not known to be 3D files
};

struct AssetKind {
  std::string_view endings;  // separated by blanks, in lower case
  AssetReader reader;
  InFolders inFolders;
};

constexpr std::array<AssetKind, 11> kKinds{{
    {".gltf .glb .b3dm", AssetReader::Gltf, InFolders::Listed},
    {".blend .fbx .abc .x3d .usd .usda .usdc .usdz", AssetReader::Blender, InFolders::Listed},
    {".obj .ply .stl .dae .ac .acc .ac3d", AssetReader::Mesh, InFolders::Listed},
    {".sdf .world .urdf", AssetReader::World, InFolders::Listed},
    {".xacro .json", AssetReader::World, InFolders::Ignored},
    {".las .pcd .xyz .drc", AssetReader::Cloud, InFolders::Listed},
    {".laz .csv .e57 .pts .ptx", AssetReader::Cloud, InFolders::Warned},
    {".tif .tiff", AssetReader::Heights, InFolders::Listed},
    {".asc", AssetReader::Heights, InFolders::Warned},
    {".hgt .vrt .img .dem", AssetReader::Heights, InFolders::Ignored},
    {".3ds .3mf .amf .dxf .ifc .lwo .off .osm .pbf .wrl .x", AssetReader::None, InFolders::Warned},
}};

// Returns the row of kKinds that has this ending (in lower case); null if there is none.
const AssetKind* kindOf(std::string_view ending) {
  const auto* const row =
      std::ranges::find_if(kKinds, [&](const AssetKind& kind) { return containsWord(kind.endings, ending); });
  return row == kKinds.end() ? nullptr : row;
}

struct Content {
  std::string_view firstBytes;  // in lower case
  std::string_view name;        // with advice, for messages
  std::string_view endings;     // endings of files with these contents, separated by blanks
};

// Kinds of contents that the first bytes of a file reveal. If several rows match, the first one is used.
constexpr std::array<Content, 22> kContents{{
    {"version https://git-lfs", "a pointer of Git LFS, not the file itself: fetch it by 'git lfs pull'", ""},
    {"\xff\xfe"sv, "UTF-16 text: save it as UTF-8, for example with 'iconv -f UTF-16 -t UTF-8'", ""},
    {"\xfe\xff"sv, "UTF-16 text: save it as UTF-8, for example with 'iconv -f UTF-16 -t UTF-8'", ""},
    {"gltf"sv, "a GLB (binary glTF)", ".glb .gltf"},
    {"kaydara fbx binary", "FBX", ".fbx"},
    {"blender", "a Blender file: rename it to .blend", ".blend"},
    {"ac3d", "AC3D", ".ac .acc .ac3d"},
    {"ply\n", "PLY", ".ply"},
    {"ply\r", "PLY", ".ply"},
    {"lasf", "a LAS or LAZ point cloud", ".las .laz"},
    {"# .pcd", "a PCD point cloud", ".pcd"},
    {"mtllib", "OBJ", ".obj"},
    {"solid", "STL", ".stl"},
    {"\x89png"sv, "a PNG image", ""},
    {"\xff\xd8\xff"sv, "a JPEG image", ""},
    {"pk\x03\x04"sv, "a ZIP archive: unpack it", ".3mf .amf .usdz"},
    {"\x1f\x8b"sv, "compressed by gzip: unpack it", ".blend"},
    {"<!doctype html", "a web page", ""},
    {"<html", "a web page", ""},
    {"<collada", "COLLADA", ".dae"},
    {"<mujoco", "MJCF of MuJoCo: convert it to URDF or SDF, or name its meshes", ".urdf .xacro"},
    {"{", "JSON", ".gltf .glb .json"},
}};

}  // namespace

AssetReader readerOf(const fs::path& file) {
  const AssetKind* const kind = kindOf(lowerExtension(file));
  return kind == nullptr ? AssetReader::None : kind->reader;
}

std::string whyNoReader(const fs::path& file) {
  if (isMap(file)) {
    return "is a map of OpenStreetMap, from which an object `town: {map: ...}` of a scene builds a town; docs/town.md "
           "says how";
  }
  return fmt::format(
      "has an unknown kind ('{}'): convert meshes to glTF, GLB, OBJ, PLY, STL, DAE, FBX, AC or BLEND, for example with "
      "Blender or FreeCAD, points to XYZ or LAS, and rasters to TIF, by gdal_translate",
      lowerExtension(file));
}

std::string otherContent(const fs::path& file) {
  const std::string ending = lowerExtension(file);
  constexpr std::size_t kExaminedBytes = 4096;  // bytes in which XML root elements are searched for
  const std::string bytes = lowerCase(firstBytes(file, kExaminedBytes));
  const std::string_view text = trimmed(textOfFile(bytes));
  const bool isXml = text.starts_with("<?xml");
  for (const Content& content : kContents) {
    const bool isRootElement = content.firstBytes == "<collada" || content.firstBytes == "<mujoco";
    const bool isInXml = isXml && isRootElement && text.find(content.firstBytes) != std::string_view::npos;
    if (!text.starts_with(content.firstBytes) && !isInXml) continue;
    return containsWord(content.endings, ending) ? "" : std::string(content.name);
  }
  return isXml && !containsWord(".dae .sdf .world .urdf .xacro .xml .x3d .amf .vrt", ending) ? "XML" : "";
}

std::vector<fs::path> assetsIn(const fs::path& folder) {
  std::error_code error;
  // Returns a folder's model.sdf or else tileset.json, which names the folder's other files; empty if it has neither.
  const auto worldIn = [&](const fs::path& path) {
    for (const char* name : {"model.sdf", "tileset.json"}) {
      if (fs::is_regular_file(path / name, error)) return path / name;
    }
    return fs::path();
  };
  if (const auto world = worldIn(folder); !world.empty()) return {world};
  std::vector<fs::path> assets;
  std::map<std::string, int> leftOut;  // number of files, by ending
  for (auto entry = fs::recursive_directory_iterator(folder, error); entry != end(entry); entry.increment(error)) {
    const std::string ending = lowerExtension(entry->path());
    const AssetKind* const kind = kindOf(ending);
    if (const auto world = worldIn(entry->path()); !world.empty()) {
      assets.push_back(world);
      entry.disable_recursion_pending();
    } else if (kind == nullptr || kind->inFolders == InFolders::Ignored || !entry->is_regular_file(error)) {
      continue;
    } else if (kind->inFolders == InFolders::Listed) {
      assets.push_back(entry->path());
    } else {
      ++leftOut[ending];
    }
  }
  std::vector<std::string> counts;
  counts.reserve(leftOut.size());
  for (const auto& [ending, files] : leftOut) counts.push_back(fmt::format("{} {}", files, ending));
  if (!counts.empty()) {
    warn(
        "{}: left out: {}: of a folder only files that are surely meshes, clouds or worlds are taken; some "
        "of the others are read if you name them, or after a conversion",
        folder.string(), fmt::join(counts, ", "));
  }
  std::ranges::sort(assets);
  return assets;
}

}  // namespace scanmill
