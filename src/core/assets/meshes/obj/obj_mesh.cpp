// Polygons of Wavefront OBJ ("Appendix B1. Object Files (.obj)" of the Advanced Visualizer's manual), whose coordinates
// are read in double precision.
//
//   v x y z [w] [r g b [a]]    a vertex; its weight and its colour are not used
//   vt u [v [w]]               texture coordinates
//   f v[/vt][/vn] ...          a polygon; negative indices count from the latest vertex
//   o NAME, g NAME             the node of the faces that follow: the group if there is one, else the object
//   usemtl NAME, mtllib FILE   materials; a line may name several libraries

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/imported_file.h"
#include "assets/meshes/obj/materials.h"
#include "assets/meshes/polygon.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "base/file.h"
#include "base/format_support.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;
using obj::Statements;

class ObjReader {
 public:
  ObjReader(const fs::path& file, const AssetOptions& options)
      : file_(file), options_(options), text_(readFile(file)), statements_(text_, file), polygons_({file.string()}) {}

  ImportedFile read() {
    while (statements_.next()) readStatement();
    read_.up = options_.up.value_or('z');
    assetFromFile_ = assetFromFile(read_.up, options_.metresPerUnit);
    read_.origin = originNear(vertices_.size(), [&](std::size_t i) { return assetFromFile_ * vertices_[i]; });
    library_.check(!libraries_.empty() && read_.missing.empty());
    for (Part& part : parts_) {
      // A texture must not show on faces without texture coordinates, which stand beside others.
      Part bare{part.node, part.nodeIndex, part.material, {}};
      if (library_.list[part.material].textured()) {
        const auto first = std::stable_partition(part.triangles.begin(), part.triangles.end(), hasUvs);
        bare.triangles.assign(first, part.triangles.end());
        part.triangles.erase(first, part.triangles.end());
      }
      if (!part.triangles.empty()) addPart(part);
      if (!bare.triangles.empty()) addPart(bare);
    }
    for (obj::ObjMaterial& material : library_.list) read_.materials.push_back(std::move(material));
    read_.leftOut.add(library_.leftOut);
    read_.leftOut.add("colours of vertices", colored_);
    return std::move(read_);
  }

 private:
  // A corner of a face: indices of its vertex and its texture coordinates.
  struct Corner {
    std::uint32_t vertex = 0;
    std::uint32_t uv = 0;  // kNone: none
  };
  static constexpr std::uint32_t kNone = UINT32_MAX;

  // The triangles of one node and material.
  struct Part {
    std::string node;
    std::uint32_t nodeIndex = 0;
    std::size_t material = 0;
    std::vector<std::array<Corner, 3>> triangles;
  };

  void readStatement() {
    const std::string_view key = statements_.keyword();
    if (key == "v") {
      readVertex();
    } else if (key == "vt") {
      readUv();
    } else if (key == "f" || key == "fo") {
      readFace();
    } else if (key == "o" || key == "g") {
      if (key == "o") {
        object_ = statements_.rest();
        if (!objects_.insert(object_).second) {
          read_.leftOut.add("further objects with the name of an earlier one (they are one node)");
        }
      }
      group_ = key == "g" ? statements_.rest() : std::string_view();
      part_ = nullptr;
    } else if (key == "usemtl") {
      material_ = statements_.rest();
      part_ = nullptr;
    } else if (key == "mtllib") {
      readLibraries();
    } else if (vertices_.empty() && objFormat().find(key) == nullptr && statements_.rest().empty()) {
      statements_.fail("is no statement of an OBJ file: is it text?");
    } else {
      read_.leftOut.addKeyword(objFormat(), key);
    }
  }

  void readVertex() {
    const auto& words = statements_.words();
    const std::size_t count = words.size();
    if (count != 3 && count != 4 && count != 6 && count != 7 && count != 8) {
      statements_.fail(
          fmt::format("has {} numbers: give x y z, and then a weight, a colour or both if you like", count));
    }
    for (const std::string_view word : words) statements_.number(word);
    vertices_.push_back({statements_.number(words[0]), statements_.number(words[1]), statements_.number(words[2])});
    if (count > 4) ++colored_;
  }

  void readUv() {
    const auto& words = statements_.words();
    if (words.empty() || words.size() > 3) statements_.fail("give one to three numbers");
    const double v = words.size() > 1 ? statements_.number(words[1]) : 0;
    uvs_.push_back({static_cast<float>(statements_.number(words[0])), static_cast<float>(v)});
  }

  // Reads an index, which counts from 1, or from the end if it is negative. Returns kNone if it is out of range.
  std::uint32_t index(std::string_view text, std::size_t count) const {
    const double number = statements_.number(text);
    if (number != std::floor(number)) statements_.fail(fmt::format("'{}' is not a whole number", text.substr(0, 40)));
    const double from0 = number < 0 ? static_cast<double>(count) + number : number - 1;
    return from0 >= 0 && from0 < static_cast<double>(count) && number != 0 ? static_cast<std::uint32_t>(from0) : kNone;
  }

  // Returns the corner that a word such as "7", "7/2", "7//3" or "7/2/3" names.
  Corner corner(std::string_view word) const {
    const std::size_t slash = std::min(word.find('/'), word.size());
    Corner corner{index(word.substr(0, slash), vertices_.size()), kNone};
    if (slash == word.size()) return corner;
    const std::string_view behind = word.substr(slash + 1);
    const std::string_view uv = behind.substr(0, behind.find('/'));
    if (!uv.empty()) corner.uv = index(uv, uvs_.size());
    return corner;
  }

  void readFace() {
    const auto& words = statements_.words();
    if (words.size() < 3) statements_.fail(fmt::format("has {} corners: a face needs three", words.size()));
    face_.clear();
    for (const std::string_view word : words) face_.push_back(corner(word));
    if (std::any_of(face_.begin(), face_.end(), [](const Corner& c) { return c.vertex == kNone; })) {
      read_.dropped.outOfRange += face_.size() - 2;
      return;
    }
    Part& part = currentPart();
    const auto cornerPosition = [this](std::size_t i) { return vertices_[face_[i].vertex]; };
    for (const auto& t : polygons_.divide(face_.size(), cornerPosition)) {
      part.triangles.push_back({face_[t[0]], face_[t[1]], face_[t[2]]});
    }
  }

  Part& currentPart() {
    if (part_ != nullptr) return *part_;
    const std::pair<std::string, std::string> names{object_, group_};
    const auto node = nodes_.try_emplace(names, static_cast<std::uint32_t>(nodes_.size() + 1)).first->second;
    const std::pair<std::uint32_t, std::size_t> key{node, library_.indexOf(material_)};
    const auto [at, isNew] = partOf_.try_emplace(key, parts_.size());
    if (isNew) parts_.push_back({group_.empty() ? object_ : group_, node, key.second, {}});
    return *(part_ = &parts_[at->second]);
  }

  // The rest of the line is one name with spaces, or several names.
  void readLibraries() {
    const std::string line(statements_.rest());
    if (line.empty()) statements_.fail("names no file");
    const std::vector<std::string_view> names = statements_.words();
    const auto exists = [&](std::string_view name) { return pathExists(pathOf(std::string(name))); };
    if (names.size() == 1 || exists(line) || std::none_of(names.begin(), names.end(), exists)) return readLibrary(line);
    for (const std::string_view name : names) readLibrary(std::string(name));
  }

  fs::path pathOf(std::string name) const {
    std::replace(name.begin(), name.end(), '\\', '/');
    return fs::absolute(file_).parent_path() / name;
  }

  void readLibrary(const std::string& name) {
    fs::path path = pathOf(name);
    if (pathExists(path) && !isFile(path)) fail(fmt::format("names '{}', which is not a file", name));
    if (pathExists(path) && !options_.allowOutside &&
        leadsOutside(path.lexically_relative(fs::absolute(file_).parent_path()).string())) {
      fail(refusalOf(name));
    }
    if (!pathExists(path)) {
      // Exporters that rename the mesh leave the old name in it.
      path = fs::absolute(file_).replace_extension(".mtl");
      if (!isFile(path)) {
        if (std::find(read_.missing.begin(), read_.missing.end(), name) == read_.missing.end())
          read_.missing.push_back(name);
        return;
      }
    }
    if (libraries_.insert(path).second) obj::readLibrary(path, library_);
  }

  static bool hasUvs(const std::array<Corner, 3>& triangle) {
    return std::none_of(triangle.begin(), triangle.end(), [](const Corner& corner) { return corner.uv == kNone; });
  }

  void addPart(Part& from) {
    AssetPart& part = read_.parts.emplace_back();
    part.node = std::move(from.node);
    part.nodeIndex = from.nodeIndex;
    part.materialIndex = static_cast<std::uint32_t>(from.material);
    const UvPlacement& placement = library_.list[from.material].placement();
    const bool anyUvs = std::any_of(from.triangles.begin(), from.triangles.end(), hasUvs);
    for (const std::array<Corner, 3>& triangle : from.triangles) {
      const auto first = static_cast<std::uint32_t>(part.positions.size());
      part.triangles.push_back({first, first + 1, first + 2});
      for (const Corner& corner : triangle) {
        part.positions.push_back(static_cast<Vec3f>(assetFromFile_ * vertices_[corner.vertex] - read_.origin));
        if (!anyUvs) continue;
        part.uvs.push_back(placement.apply(corner.uv == kNone ? Vec2f{} : uvs_[corner.uv]));
      }
    }
    from.triangles = {};
    weld(part.positions, part.uvs, part.triangles);
  }

  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_.string()}, what); }

  const fs::path& file_;
  const AssetOptions& options_;
  std::string text_;
  Statements statements_;
  Mat3 assetFromFile_;
  std::vector<Vec3d> vertices_;  // in the file's units and axes
  std::vector<Vec2f> uvs_;
  std::string object_, group_, material_;                                // names that hold for the faces that follow
  std::set<std::string> objects_;                                        // names of objects so far
  std::map<std::pair<std::string, std::string>, std::uint32_t> nodes_;   // index of the node of an object and a group
  std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> partOf_;  // index of the part of a node and a material
  std::vector<Part> parts_;
  Part* part_ = nullptr;  // part of the faces that follow; null: not looked up yet
  obj::Materials library_;
  std::set<fs::path> libraries_;  // that were read
  std::uint64_t colored_ = 0;     // number of vertices with a colour
  Triangulator polygons_;
  std::vector<Corner> face_;
  ImportedFile read_;
};

}  // namespace

const FormatSupport& objFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "OBJ",
      ".obj, .mtl",
      {{Unused, "vn s mg lod bevel c_interp d_interp maplib shadow_obj trace_obj"},
       {Unused, "vp deg bmat step cstype parm trim hole scrv sp con ctech stech res end"},
       {Unused, "Ka Ks Ke Ns Ni Tf illum sharpness Ps Pc Pcr aniso anisor"},
       {Unused, "map_Ka map_Ks map_Ke map_Ns map_bump map_Bump bump norm disp refl map_refl"},
       {Unused, "map_Pr map_Pm map_Ps map_aat map_Ni map_Tf"},
       {LeftOut, "l", "lines (l)"},
       {LeftOut, "p", "points (p)"},
       {LeftOut, "surf", "free-form surfaces (surf)"},
       {LeftOut, "curv curv2", "free-form curves (curv, curv2)"},
       {LeftOut, "call csh", "other files and commands (call, csh)"},
       {LeftOut, "usemap", "images of map libraries (usemap)"}},
      "Coordinates in double precision; polygons are divided into triangles. The faces of one object (o) and group (g) "
      "are one node. Of materials: Kd, d, Tr, Pr, Pm, map_Kd and map_d, with -s and -o of images. Kd is taken as "
      "linear light, as in Blender, since OBJ states no colour space; an image counts in its place. The first "
      "definition of a name counts. Normals, lighting and its images change nothing",
      "further objects with the name of an earlier one, which are one node; colours of vertices; materials that no "
      "library defines, further definitions of a name; options of images but -s and -o; placements of map_d that "
      "differ from those of map_Kd; opacities and textures that cannot show"};
  return format;
}

ImportedFile readObjMesh(const std::filesystem::path& file, const AssetOptions& options) {
  return ObjReader(file, options).read();
}

}  // namespace scanmill
