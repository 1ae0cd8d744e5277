#include "assets/asset_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "config/file_kind.h"
#include "config/text.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

enum class InFolders {
  Listed,  // surely meshes, clouds or worlds
  Warned,  // left out with a warning
  Ignored  // not known to be 3D files
};

// Advice on kinds that are not read. {0} is the file, {1} the file without its ending.
constexpr std::string_view kByAssimp = "convert it by `assimp export {0} {1}.glb` (Debian's package assimp-utils)";
constexpr std::string_view kByTrimesh =
    "convert it by `python3 -c \"import trimesh; trimesh.load('{0}').export('{1}.ply')\"`";
constexpr std::string_view kByGdal = "convert it by `gdal_translate {0} {1}.tif`";

struct AssetKind {
  std::string_view endings;  // separated by blanks, in lower case
  AssetReader reader;
  InFolders inFolders;
  std::string_view advice = {};
};

constexpr std::array<AssetKind, 16> kKinds{{
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
    {".3ds .x", AssetReader::None, InFolders::Warned, kByAssimp},
    {".off", AssetReader::None, InFolders::Warned, kByTrimesh},
    {".hdr", AssetReader::None, InFolders::Ignored,
     "convert it by `gdal_translate {0} {1}.tif`, with the file of the values in place of their header"},
    {".adf .bil .bip .bsq .bt .ers .flt .gpkg .grd .gtx .jp2 .nc .pix .rst .sdat", AssetReader::None,
     InFolders::Ignored, kByGdal},
    {".txt", AssetReader::None, InFolders::Ignored,
     "if it holds points, give it the ending .xyz, and a first line of names (x y z intensity ...) if it has more than "
     "x, y and z"},
    {".3mf .amf .dxf .ifc .lwo .osm .pbf .wrl", AssetReader::None, InFolders::Warned},
}};

struct Content {
  std::string_view begin;  // first bytes, in lower case
  std::string_view what;
  std::string_view endings;  // endings of files that begin so
};

// True if a list of endings, which are separated by blanks, has this ending.
bool hasEnding(std::string_view endings, std::string_view kind) {
  const std::string between = fmt::format(" {} ", kind);
  return !kind.empty() && fmt::format(" {} ", endings).find(between) != std::string::npos;
}

// Returns the row of an ending; null if none has it.
const AssetKind* kindOf(const std::string& ending) {
  const auto* found = std::find_if(kKinds.begin(), kKinds.end(),
                                   [&](const AssetKind& kind) { return hasEnding(kind.endings, ending); });
  return found == kKinds.end() ? nullptr : found;
}

// The first row that fits counts.
constexpr std::array<Content, 27> kContents{{
    {"version https://git-lfs", "a pointer of Git LFS, not the file itself: fetch it by 'git lfs pull'", ""},
    {"\xff\xfe"sv, "UTF-16 text: save it as UTF-8, for example with 'iconv -f UTF-16 -t UTF-8'", ""},
    {"\xfe\xff"sv, "UTF-16 text: save it as UTF-8, for example with 'iconv -f UTF-16 -t UTF-8'", ""},
    {"gltf"sv, "a GLB (binary glTF)", ".glb .gltf"},
    {"b3dm"sv, "a tile of 3D Tiles (b3dm)", ".b3dm"},
    {"kaydara fbx binary", "FBX", ".fbx"},
    {"; fbx", "FBX", ".fbx"},
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
    {"%pdf", "a PDF", ""},
    {"pk\x03\x04"sv, "a ZIP archive: unpack it", ".3mf .amf .usdz"},
    {"\x1f\x8b"sv, "compressed by gzip: unpack it", ".blend"},
    {"7z\xbc\xaf"sv, "a 7z archive: unpack it", ""},
    {"rar!", "a RAR archive: unpack it", ""},
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
  const std::string ending = lowerExtension(file);
  const AssetKind* const kind = kindOf(ending);
  if (kind == nullptr || kind->advice.empty()) {
    return fmt::format(
        "has an unknown kind ('{}'): convert it to glTF, GLB, OBJ, PLY, STL, DAE, FBX, AC or BLEND, for example with "
        "Blender or FreeCAD",
        ending);
  }
  return fmt::format(
      "has a kind that is not read ('{}'): {}", ending,
      fmt::format(fmt::runtime(kind->advice), file.string(), fs::path(file).replace_extension().string()));
}

std::string otherContent(const fs::path& file) {
  const std::string kind = lowerExtension(file);
  const std::string head = lowerCase(firstBytes(file, 4096));
  std::string_view begin = head;
  if (begin.starts_with("\xef\xbb\xbf")) begin.remove_prefix(3);
  begin.remove_prefix(std::min(begin.find_first_not_of(" \t\r\n"), begin.size()));
  const bool xml = begin.starts_with("<?xml");
  for (const Content& content : kContents) {
    const bool root = content.begin == "<collada" || content.begin == "<mujoco";
    const bool inside = xml && root && begin.find(content.begin) != std::string_view::npos;
    if (!begin.starts_with(content.begin) && !inside) continue;
    return hasEnding(content.endings, kind) ? "" : std::string(content.what);
  }
  return xml && !hasEnding(".dae .sdf .world .urdf .xacro .xml .x3d .amf .vrt", kind) ? "XML" : "";
}

std::vector<fs::path> assetsIn(const fs::path& folder) {
  std::error_code error;
  const auto worldIn = [&](const fs::path& path) {
    for (const char* name : {"model.sdf", "tileset.json"}) {
      if (fs::is_regular_file(path / name, error)) return path / name;
    }
    return fs::path();
  };
  if (const auto world = worldIn(folder); !world.empty()) return {world};
  std::vector<fs::path> found;
  std::map<std::string, int> leftOut;  // number of files, by ending
  for (auto at = fs::recursive_directory_iterator(folder, error); at != end(at); at.increment(error)) {
    const fs::directory_entry& entry = *at;
    const std::string ending = lowerExtension(entry.path());
    const AssetKind* const kind = kindOf(ending);
    if (const auto world = worldIn(entry.path()); !world.empty()) {
      found.push_back(world);
      at.disable_recursion_pending();
    } else if (kind == nullptr || kind->inFolders == InFolders::Ignored || !entry.is_regular_file(error)) {
      continue;
    } else if (kind->inFolders == InFolders::Listed) {
      found.push_back(entry.path());
    } else {
      ++leftOut[ending];
    }
  }
  std::string counts;
  for (const auto& [kind, count] : leftOut) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, kind);
  if (!counts.empty()) {
    warn(
        fmt::format("{}: left out: {}: of a folder only files that are surely meshes, clouds or worlds are taken; some "
                    "of the others are read if you name them, or after a conversion",
                    folder.string(), counts));
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace scanmill
