#include "assets/content_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "config/text.h"

namespace scanmill {

namespace {

struct Content {
  std::string_view begin;  // first bytes, in lower case
  std::string_view what;
  std::string_view endings;  // endings of files that begin so
};

using namespace std::string_view_literals;

// True if a list of endings, which are separated by blanks, has this ending.
bool hasEnding(std::string_view endings, std::string_view kind) {
  const std::string between = fmt::format(" {} ", kind);
  return !kind.empty() && fmt::format(" {} ", endings).find(between) != std::string::npos;
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
    {"pk\x03\x04"sv, "a ZIP archive: unpack it", ".3mf .amf"},
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

std::string otherContent(const std::filesystem::path& file, const std::string& kind) {
  std::string head(4096, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  head = lowerCase(head);
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

}  // namespace scanmill
