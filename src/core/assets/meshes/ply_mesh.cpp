// Meshes of PLY, in text and binary, whose properties may have any type.
//
//   element vertex     x y z; s t, u v or texture_u texture_v: texture coordinates
//   element face       vertex_indices or vertex_index; texcoord: texture coordinates of its corners; texnumber: index
//                      of its image
//   comment TextureFile NAME    an image, as MeshLab writes it

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/imported_file.h"
#include "assets/meshes/polygon.h"
#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"
#include "formats/ply_file.h"

namespace scanmill {

namespace {

// The meaning of a property.
enum class Role { None, X, Y, Z, U, V, Corners, CornerUvs, Image };
constexpr std::size_t kRoles = 9;

Role roleOf(std::string_view element, const PlyProperty& property) {
  struct Row {
    std::string_view element, names;  // names with blanks around them
    bool isList;
    Role role;
  };
  static constexpr std::array<Row, 8> kRows{{{"vertex", " x ", false, Role::X},
                                             {"vertex", " y ", false, Role::Y},
                                             {"vertex", " z ", false, Role::Z},
                                             {"vertex", " s u texture_u ", false, Role::U},
                                             {"vertex", " t v texture_v ", false, Role::V},
                                             {"face", " vertex_indices vertex_index ", true, Role::Corners},
                                             {"face", " texcoord ", true, Role::CornerUvs},
                                             {"face", " texnumber ", false, Role::Image}}};
  for (const Row& row : kRows) {
    if (row.element == element && row.isList == property.isList() &&
        row.names.find(fmt::format(" {} ", property.name)) != std::string_view::npos) {
      return row.role;
    }
  }
  return Role::None;
}

class PlyMeshReader {
 public:
  PlyMeshReader(const std::filesystem::path& file, const AssetOptions& options)
      : file_(file),
        options_(options),
        header_(readPlyHeader(file)),
        bytes_(readFile(file)),
        body_(file, header_, bytes_),
        polygons_({file.string()}) {}

  ImportedFile read() {
    readComments();
    for (const PlyElement& element : header_.elements) readElement(element);
    read_.leftOut.addRest(body_.rest());
    countLoose();
    makeParts();
    for (const bool used : imageUsed_) read_.leftOut.add("images that no face shows (TextureFile)", used ? 0 : 1);
    return std::move(read_);
  }

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_.string()}, what); }

  // Counts vertices that no face uses, where they are more than half: such a file has points besides its faces.
  void countLoose() {
    std::vector<bool> used(vertices_.size());
    for (const AssetPart& part : read_.parts) {
      for (const Triangle& triangle : part.triangles) {
        for (const std::uint32_t corner : triangle) used[corner] = true;
      }
    }
    const auto loose = static_cast<std::uint64_t>(std::count(used.begin(), used.end(), false));
    if (2 * loose > used.size()) read_.leftOut.add("vertices that no face uses", loose);
  }

  void readComments() {
    constexpr std::string_view kImage = "comment TextureFile ";
    for (std::string_view head = std::string_view(bytes_).substr(0, header_.size); !head.empty();) {
      const std::string_view line = takeLine(head);
      if (line.starts_with(kImage)) images_.emplace_back(trimmed(line.substr(kImage.size())));
    }
    imageUsed_.resize(images_.size());
  }

  // Throws InputError for elements that cannot be read. `roles`: of the element's properties.
  void checkElement(const PlyElement& element, const std::vector<Role>& roles) const {
    const auto has = [&](Role role) { return std::find(roles.begin(), roles.end(), role) != roles.end(); };
    const bool isVertex = element.name == "vertex";
    const bool isFace = element.name == "face";
    if (isVertex && !(has(Role::X) && has(Role::Y) && has(Role::Z))) {
      fail(fmt::format("its vertices have no property {}: export it with x, y and z", !has(Role::X)   ? "x"
                                                                                      : !has(Role::Y) ? "y"
                                                                                                      : "z"));
    }
    if (isVertex && !vertices_.empty()) fail("has two elements 'vertex': export it with one");
    if (isVertex && element.count > UINT32_MAX) fail("has more vertices than 32-bit indices allow: split it");
    if (isFace && !has(Role::Corners)) fail("its faces have no list vertex_indices: export it with that list");
    if (isFace && vertices_.empty()) fail("has no vertices before its faces: export it with vertices first");
    if (element.name == "tristrips") fail("has triangle strips, which are not supported: export it with faces");
  }

  void readElement(const PlyElement& element) {
    if (element.count == 0) return;
    std::vector<Role> roles;
    for (const PlyProperty& property : element.properties) roles.push_back(roleOf(element.name, property));
    checkElement(element, roles);
    countLeftOut(element, roles);
    if (element.properties.empty()) return;
    const bool isVertex = element.name == "vertex";
    const auto has = [&](Role role) { return std::find(roles.begin(), roles.end(), role) != roles.end(); };
    hasUvs_ = hasUvs_ || (isVertex && has(Role::U) && has(Role::V));
    values_ = {};
    for (std::vector<double>& numbers : lists_) numbers.clear();
    for (std::uint64_t row = 0; row < element.count; ++row) {
      body_.beginRow(element, row);
      for (std::size_t i = 0; i < roles.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        const auto role = static_cast<std::size_t>(roles[i]);
        if (!property.isList()) {
          values_[role] = body_.number(property);
          continue;
        }
        lists_[role].clear();
        for (std::uint64_t remaining = body_.length(property); remaining > 0; --remaining) {
          lists_[role].push_back(body_.number(property));
        }
      }
      if (isVertex) addVertex();
      if (element.name == "face") addFace();
    }
  }

  void countLeftOut(const PlyElement& element, const std::vector<Role>& roles) {
    const bool isVertex = element.name == "vertex";
    read_.leftOut.addKeyword(plyMeshFormat(), element.name);
    if (!isVertex && element.name != "face") return;
    bool colored = false;
    for (std::size_t i = 0; i < roles.size(); ++i) {
      const std::string& name = element.properties[i].name;
      if (const FormatElements* row = plyMeshFormat().find(name);
          row != nullptr && row == plyMeshFormat().find("red")) {
        colored = true;
      } else if (roles[i] == Role::None && plyMeshFormat().has(FormatElements::Use::Read, name)) {
        read_.leftOut.add(fmt::format("'{}' of {}", name, isVertex ? "vertices" : "faces"));
      } else {
        read_.leftOut.addKeyword(plyMeshFormat(), name);
      }
    }
    if (colored) read_.leftOut.add(isVertex ? "colours of vertices" : "colours of faces", element.count);
  }

  double value(Role role) const { return values_[static_cast<std::size_t>(role)]; }
  const std::vector<double>& list(Role role) const { return lists_[static_cast<std::size_t>(role)]; }

  void addVertex() {
    vertices_.push_back({value(Role::X), value(Role::Y), value(Role::Z)});
    if (hasUvs_) uvs_.push_back({static_cast<float>(value(Role::U)), static_cast<float>(value(Role::V))});
  }

  // Returns the number as an index; kNone if it is none of `count` indices.
  static std::uint32_t indexOf(double number, std::size_t count) {
    return number >= 0 && number < static_cast<double>(count) ? static_cast<std::uint32_t>(number) : kNone;
  }

  void addFace() {
    const std::vector<double>& indices = list(Role::Corners);
    if (indices.size() < 3) return read_.leftOut.add("faces of fewer than three corners");
    corners_.clear();
    for (const double corner : indices) corners_.push_back(indexOf(corner, vertices_.size()));
    if (std::find(corners_.begin(), corners_.end(), kNone) != corners_.end()) {
      read_.dropped.outOfRange += corners_.size() - 2;
      return;
    }
    const std::vector<double>& uvs = list(Role::CornerUvs);
    const bool hasUvs = uvs.size() == 2 * corners_.size();
    if (!hasUvs && !uvs.empty()) read_.leftOut.add("texture coordinates of faces that are not two a corner");
    AssetPart& part = partOf(indexOf(value(Role::Image), images_.size()), hasUvs);
    for (const auto& t : polygons_.divide(corners_.size(), [this](std::size_t i) { return vertices_[corners_[i]]; })) {
      part.triangles.push_back({corners_[t[0]], corners_[t[1]], corners_[t[2]]});
      for (const std::uint32_t corner : t) {
        if (!hasUvs) break;
        part.uvs.push_back({static_cast<float>(uvs[2 * corner]), static_cast<float>(uvs[2 * corner + 1])});
      }
    }
  }

  AssetPart& partOf(std::uint32_t image, bool hasUvs) {
    const auto [at, isNew] = parts_.try_emplace({image, hasUvs}, read_.parts.size());
    if (isNew) {
      read_.parts.emplace_back().materialIndex = static_cast<std::uint32_t>(at->second);
      ImportedMaterial& material = read_.materials.emplace_back();
      material.stated = false;
      if (image != kNone) {
        material.base.name = images_[image];
        imageUsed_[image] = true;
      }
    }
    return read_.parts[at->second];
  }

  // Gives the parts, whose triangles have indices of the file and whose texture coordinates are those of corners, their
  // vertices.
  void makeParts() {
    read_.up = options_.up.value_or('z');
    const Mat3 frame = assetFromFile(read_.up, options_.metresPerUnit);
    for (Vec3d& vertex : vertices_) vertex = frame * vertex;
    read_.origin = origin();
    for (AssetPart& part : read_.parts) {
      const auto positionOf = [&](std::size_t i) { return static_cast<Vec3f>(vertices_[i] - read_.origin); };
      if (read_.parts.size() == 1 && part.uvs.empty()) {
        for (std::size_t i = 0; i < vertices_.size(); ++i) part.positions.push_back(positionOf(i));
        part.uvs = std::move(uvs_);
      } else {
        const bool ofVertices = hasUvs_ && part.uvs.empty();
        for (Triangle& triangle : part.triangles) {
          for (std::uint32_t& corner : triangle) {
            part.positions.push_back(positionOf(corner));
            if (ofVertices) part.uvs.push_back(uvs_[corner]);
            corner = static_cast<std::uint32_t>(part.positions.size() - 1);
          }
        }
      }
      weld(part.positions, part.uvs, part.triangles);
    }
  }

  // Returns an origin near most vertices (m, along the asset's axes). In single precision it would not refine the
  // coordinates.
  Vec3d origin() const {
    const auto isExact = [](const PlyProperty& p) { return p.name.size() == 1 && p.value.size == 8; };
    const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                     [](const PlyElement& element) { return element.name == "vertex"; });
    if (vertex == header_.elements.end() ||
        (header_.format != PlyHeader::Format::Ascii &&
         std::none_of(vertex->properties.begin(), vertex->properties.end(), isExact))) {
      return {};
    }
    return originNear(vertices_.size(), [this](std::size_t i) { return vertices_[i]; });
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  PlyHeader header_;
  std::string bytes_;
  PlyBody body_;
  std::array<double, kRoles> values_{};              // the latest number of each role
  std::array<std::vector<double>, kRoles> lists_{};  // the latest list of each role
  std::vector<Vec3d> vertices_;                      // in the file's units and axes, until makeParts()
  bool hasUvs_ = false;                              // true: vertices have texture coordinates
  std::vector<Vec2f> uvs_;                           // of the vertices
  std::vector<std::string> images_;
  std::vector<bool> imageUsed_;
  // Indices of the parts, by image (kNone: none) and by whether corners have texture coordinates of their own.
  std::map<std::pair<std::uint32_t, bool>, std::size_t> parts_;
  Triangulator polygons_;
  std::vector<std::uint32_t> corners_;
  ImportedFile read_;
};

}  // namespace

const FormatSupport& plyMeshFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "PLY of triangles",
      ".ply with faces",
      {{Read, "vertex face x y z vertex_indices vertex_index s t u v texture_u texture_v texcoord texnumber"},
       {Unused, "nx ny nz normal_x normal_y normal_z quality confidence curvature radius flags camera"},
       {LeftOut, "red green blue alpha r g b a diffuse_red diffuse_green diffuse_blue",
        "colours of vertices and of faces"},
       {LeftOut, "edge", "elements 'edge'"},
       {LeftOut, "material material_index material_indices", "materials of faces (material_index)"},
       {LeftOut, "label labels category_id objectid object_id instance",
        "columns of labels or instances (without its faces, as a cloud, the file keeps them)"}},
      "Polygons of three corners and more; coordinates in double or text lose no digits. Texture coordinates of "
      "vertices or of corners; a face's image is numbered by texnumber among the comments 'TextureFile NAME'",
      "images that no face shows; textures of parts without texture coordinates; faces of fewer than three corners; "
      "vertices that no face uses, if they are more than half; bytes behind the stated contents; all other properties "
      "and elements"};
  return format;
}

ImportedFile readPlyMesh(const std::filesystem::path& file, const AssetOptions& options) {
  return PlyMeshReader(file, options).read();
}

}  // namespace scanmill
