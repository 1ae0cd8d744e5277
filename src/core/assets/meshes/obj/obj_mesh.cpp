// Reads the polygons of Wavefront OBJ files ("Appendix B1. Object Files (.obj)" of the Advanced Visualizer's manual),
// with coordinates in double precision.
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
    placePositions(vertices_, true, options_, imported_);
    materials_.check(!libraries_.empty() && imported_.missing.empty());
    for (Part& part : parts_) {
      // Faces without texture coordinates become a separate part, since no texture must show on them.
      Part untextured{part.node, part.nodeIndex, part.material, {}};
      if (materials_.list[part.material].namesImages()) {
        const auto first = std::stable_partition(part.triangles.begin(), part.triangles.end(), hasUvs);
        untextured.triangles.assign(first, part.triangles.end());
        part.triangles.erase(first, part.triangles.end());
      }
      if (!part.triangles.empty()) addPart(part);
      if (!untextured.triangles.empty()) addPart(untextured);
    }
    for (obj::ObjMaterial& material : materials_.list) imported_.materials.push_back(std::move(material));
    imported_.leftOut.add(materials_.leftOut);
    imported_.leftOut.add("colours of vertices", coloredVertices_);
    return std::move(imported_);
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
    std::size_t material = 0;  // index into materials_.list
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
          imported_.leftOut.add("further objects with the name of an earlier one (they are one node)");
        }
      }
      group_ = key == "g" ? statements_.rest() : std::string_view();
      currentPart_ = nullptr;
    } else if (key == "usemtl") {
      material_ = statements_.rest();
      currentPart_ = nullptr;
    } else if (key == "mtllib") {
      readLibraries();
    } else if (vertices_.empty() && kObjFormat.useOf(key) == FormatSupport::Use::Unknown &&
               statements_.rest().empty()) {
      statements_.fail("is no statement of an OBJ file: is it text?");
    } else {
      imported_.leftOut.addKeyword(kObjFormat, key);
    }
  }

  void readVertex() {
    const auto& words = statements_.words();
    const std::size_t count = words.size();  // 3 of a position, 1 of a weight, 3 or 4 of a colour
    if (count != 3 && count != 4 && count != 6 && count != 7 && count != 8) {
      statements_.fail(
          fmt::format("has {} numbers: give x y z, and then a weight, a colour or both if you like", count));
    }
    for (const std::string_view word : words) statements_.number(word);
    vertices_.push_back({statements_.number(words[0]), statements_.number(words[1]), statements_.number(words[2])});
    if (count > 4) ++coloredVertices_;  // a colour follows the position or the weight
  }

  void readUv() {
    const auto& words = statements_.words();
    if (words.empty() || words.size() > 3) statements_.fail("give one to three numbers");
    const double v = words.size() > 1 ? statements_.number(words[1]) : 0;
    uvs_.push_back({static_cast<float>(statements_.number(words[0])), static_cast<float>(v)});
  }

  // Converts an index in the text, which counts from 1 or, if negative, back from the end of a list of `count`
  // elements, to an index that counts from 0. Returns kNone if it is out of range.
  std::uint32_t indexOf(std::string_view text, std::size_t count) const {
    const double number = statements_.number(text);
    if (number != std::floor(number)) statements_.fail(fmt::format("'{}' is not a whole number", text.substr(0, 40)));
    const double index = number < 0 ? static_cast<double>(count) + number : number - 1;
    return index >= 0 && index < static_cast<double>(count) && number != 0 ? static_cast<std::uint32_t>(index) : kNone;
  }

  // Returns the corner that a word such as "7", "7/2", "7//3" or "7/2/3" names.
  Corner cornerOf(std::string_view word) const {
    const std::size_t slash = std::min(word.find('/'), word.size());
    Corner corner{indexOf(word.substr(0, slash), vertices_.size()), kNone};
    if (slash == word.size()) return corner;
    const std::string_view textBehind = word.substr(slash + 1);
    const std::string_view uv = textBehind.substr(0, textBehind.find('/'));
    if (!uv.empty()) corner.uv = indexOf(uv, uvs_.size());
    return corner;
  }

  void readFace() {
    const auto& words = statements_.words();
    if (words.size() < 3) statements_.fail(fmt::format("has {} corners: a face needs three", words.size()));
    face_.clear();
    for (const std::string_view word : words) face_.push_back(cornerOf(word));
    if (std::ranges::find(face_, kNone, &Corner::vertex) != face_.end()) {
      imported_.dropped.outOfRange += face_.size() - 2;
      return;
    }
    Part& part = currentPart();
    const auto cornerPosition = [this](std::size_t i) { return vertices_[face_[i].vertex]; };
    for (const auto& t : polygons_.divide(face_.size(), cornerPosition)) {
      part.triangles.push_back({face_[t[0]], face_[t[1]], face_[t[2]]});
    }
  }

  Part& currentPart() {
    if (currentPart_ != nullptr) return *currentPart_;
    const std::pair<std::string, std::string> names{object_, group_};
    const auto node = nodes_.try_emplace(names, static_cast<std::uint32_t>(nodes_.size() + 1)).first->second;
    const std::size_t material = materials_.indexOf(material_);
    const auto [index, isNew] = partOf_.try_emplace({node, material}, parts_.size());
    if (isNew) parts_.push_back({group_.empty() ? object_ : group_, node, material, {}});
    return *(currentPart_ = &parts_[index->second]);
  }

  // Reads the libraries that a line names: one name with spaces, or several names.
  void readLibraries() {
    const std::string line(statements_.rest());
    if (line.empty()) statements_.fail("names no file");
    const std::vector<std::string_view> names = statements_.words();
    const auto exists = [&](std::string_view name) { return pathExists(pathOf(std::string(name))); };
    if (names.size() == 1 || exists(line) || std::ranges::none_of(names, exists)) return readLibrary(line);
    for (const std::string_view name : names) readLibrary(std::string(name));
  }

  fs::path pathOf(std::string name) const {
    std::replace(name.begin(), name.end(), '\\', '/');
    return fs::absolute(file_).parent_path() / name;
  }

  // Reads the library `name` or, if it is missing, the library named like the OBJ. Does not read any library twice.
  void readLibrary(const std::string& name) {
    fs::path path = pathOf(name);
    if (pathExists(path) && !isFile(path)) fail(fmt::format("names '{}', which is not a file", name));
    if (pathExists(path) && !options_.allowOutside &&
        leadsOutside(path.lexically_relative(fs::absolute(file_).parent_path()).string())) {
      fail(refusalOf(name));
    }
    if (!pathExists(path)) {
      // If a program has renamed the OBJ and its library together, the OBJ still names the old library.
      path = fs::absolute(file_).replace_extension(".mtl");
      if (!isFile(path)) {
        std::vector<std::string>& missing = imported_.missing;
        if (std::ranges::find(missing, name) == missing.end()) missing.push_back(name);
        return;
      }
    }
    if (libraries_.insert(path).second) obj::readLibrary(path, materials_);
  }

  static bool hasUvs(const std::array<Corner, 3>& triangle) {
    return std::ranges::find(triangle, kNone, &Corner::uv) == triangle.end();
  }

  // Adds a part to the asset, and frees its triangles.
  void addPart(Part& part) {
    AssetPart& added = imported_.parts.emplace_back();
    added.node = std::move(part.node);
    added.nodeIndex = part.nodeIndex;
    added.materialIndex = static_cast<std::uint32_t>(part.material);
    const UvPlacement& placement = materials_.list[part.material].placement();
    const bool anyUvs = std::ranges::any_of(part.triangles, hasUvs);
    for (const std::array<Corner, 3>& triangle : part.triangles) {
      for (const Corner& corner : triangle) {
        added.positions.push_back(static_cast<Vec3f>(vertices_[corner.vertex] - imported_.origin));
        if (anyUvs) added.uvs.push_back(placement.apply(corner.uv == kNone ? Vec2f{} : uvs_[corner.uv]));
      }
    }
    part.triangles = {};
    makeTriangles(added);
  }

  [[noreturn]] void fail(const std::string& problem) const { throw InputError({file_.string()}, problem); }

  const fs::path& file_;
  const AssetOptions& options_;
  std::string text_;
  Statements statements_;
  std::vector<Vec3d> vertices_;  // in the file's units and axes; once all is read, in m along the asset's axes
  std::vector<Vec2f> uvs_;
  std::string object_, group_, material_;                                // names that hold for the faces that follow
  std::set<std::string> objects_;                                        // names of objects so far
  std::map<std::pair<std::string, std::string>, std::uint32_t> nodes_;   // index of the node of an object and a group
  std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> partOf_;  // index of the part of a node and a material
  std::vector<Part> parts_;
  Part* currentPart_ = nullptr;  // part of the faces that follow; null: not looked up yet
  obj::Materials materials_;
  std::set<fs::path> libraries_;  // material libraries that were read
  std::uint64_t coloredVertices_ = 0;
  Triangulator polygons_;
  std::vector<Corner> face_;  // corners of the latest face
  ImportedFile imported_;
};

}  // namespace

const FormatSupport kObjFormat{
    "OBJ",
    ".obj, .mtl",
    "Coordinates in double precision; polygons are divided into triangles. The faces of one object (o) and group (g) "
    "are one node. Of materials: Kd, d, Tr, Pr, Pm, map_Kd and map_d, with -s and -o of images. Kd is taken as "
    "linear light, as in Blender, since OBJ states no colour space; an image counts in its place. The first "
    "definition of a name counts. Normals, lighting and its images change nothing",
    "further objects with the name of an earlier one, which are one node; colours of vertices; materials that no "
    "library defines, further definitions of a name; options of images but -s and -o; placements of map_d that "
    "differ from those of map_Kd; opacities and textures that cannot show",
    {.unused = {"vn s mg lod bevel c_interp d_interp maplib shadow_obj trace_obj vp deg bmat step cstype parm trim",
                "hole scrv sp con ctech stech res end Ka Ks Ke Ns Ni Tf illum sharpness Ps Pc Pcr aniso anisor",
                "map_Ka map_Ks map_Ke map_Ns map_bump map_Bump bump norm disp refl map_refl map_Pr map_Pm map_Ps",
                "map_aat map_Ni map_Tf"},
     .leftOut = {{"l", "lines (l)"},
                 {"p", "points (p)"},
                 {"surf", "free-form surfaces (surf)"},
                 {"curv curv2", "free-form curves (curv, curv2)"},
                 {"call csh", "other files and commands (call, csh)"},
                 {"usemap", "images of map libraries (usemap)"}}}};

ImportedFile readObjMesh(const std::filesystem::path& file, const AssetOptions& options) {
  return ObjReader(file, options).read();
}

}  // namespace scanmill
