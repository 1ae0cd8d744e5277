// Reads meshes from PLY files, text or binary. Properties may have any type.
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

// Returns the meaning of a property of an element; None if it is not read.
Role roleOf(std::string_view element, const PlyProperty& property) {
  enum Kind { Number, List };
  struct Row {
    std::string_view element, names;
    Kind kind;
    Role role;
  };
  static constexpr std::array<Row, 8> kRows{{{"vertex", "x", Number, Role::X},
                                             {"vertex", "y", Number, Role::Y},
                                             {"vertex", "z", Number, Role::Z},
                                             {"vertex", "s u texture_u", Number, Role::U},
                                             {"vertex", "t v texture_v", Number, Role::V},
                                             {"face", "vertex_indices vertex_index", List, Role::Corners},
                                             {"face", "texcoord", List, Role::CornerUvs},
                                             {"face", "texnumber", Number, Role::Image}}};
  const auto* const row = std::ranges::find_if(kRows, [&](const Row& known) {
    return known.element == element && (known.kind == List) == property.isList() &&
           containsWord(known.names, property.name);
  });
  return row == kRows.end() ? Role::None : row->role;
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
    imported_.leftOut.addRest(body_.rest());
    countUnusedVertices();
    addVerticesToParts();
    const auto unusedImages = static_cast<std::uint64_t>(std::ranges::count(isImageUsed_, false));
    imported_.leftOut.add("images that no face shows (TextureFile)", unusedImages);
    return std::move(imported_);
  }

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  [[noreturn]] void fail(const std::string& problem) const { throw InputError({file_.string()}, problem); }

  // Counts vertices that no face uses, if they are more than half: such a file has points besides its faces.
  void countUnusedVertices() {
    std::vector<bool> isUsed(vertices_.size());
    for (const AssetPart& part : imported_.parts) {
      for (const Triangle& triangle : part.triangles) {
        for (const std::uint32_t corner : triangle) isUsed[corner] = true;
      }
    }
    const auto unused = static_cast<std::uint64_t>(std::ranges::count(isUsed, false));
    if (2 * unused > isUsed.size()) imported_.leftOut.add("vertices that no face uses", unused);
  }

  // Reads the names of images from the comments of the header.
  void readComments() {
    constexpr std::string_view kImage = "comment TextureFile ";
    for (std::string_view unreadHeader = std::string_view(bytes_).substr(0, header_.size); !unreadHeader.empty();) {
      const std::string_view line = takeLine(unreadHeader);
      if (line.starts_with(kImage)) images_.emplace_back(trimmed(line.substr(kImage.size())));
    }
    isImageUsed_.resize(images_.size());
  }

  // Throws InputError for elements that cannot be read. `roles`: the roles of the element's properties.
  void checkElement(const PlyElement& element, const std::vector<Role>& roles) const {
    const auto has = [&](Role role) { return std::ranges::find(roles, role) != roles.end(); };
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

  // Reads all rows of an element. All elements before it must have been read.
  void readElement(const PlyElement& element) {
    if (element.count == 0) return;
    std::vector<Role> roles;
    for (const PlyProperty& property : element.properties) roles.push_back(roleOf(element.name, property));
    checkElement(element, roles);
    countLeftOut(element, roles);
    if (element.properties.empty()) return;
    const bool isVertex = element.name == "vertex";
    const auto has = [&](Role role) { return std::ranges::find(roles, role) != roles.end(); };
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
      if (element.name == "face") addFace();
      if (!isVertex) continue;
      vertices_.push_back({value(Role::X), value(Role::Y), value(Role::Z)});
      if (hasUvs_) uvs_.push_back({static_cast<float>(value(Role::U)), static_cast<float>(value(Role::V))});
    }
  }

  // Counts the contents of an element that are not read. `roles`: the roles of its properties.
  void countLeftOut(const PlyElement& element, const std::vector<Role>& roles) {
    const bool isVertex = element.name == "vertex";
    imported_.leftOut.addKeyword(kPlyMeshFormat, element.name);
    if (!isVertex && element.name != "face") return;
    bool hasColors = false;
    for (std::size_t i = 0; i < roles.size(); ++i) {
      const std::string& name = element.properties[i].name;
      if (kPlyMeshFormat.noteOf(name) == kPlyMeshFormat.noteOf("red")) {  // the row of all colours
        hasColors = true;
      } else if (roles[i] == Role::None && kPlyMeshFormat.useOf(name) == FormatSupport::Use::Read) {
        imported_.leftOut.add(fmt::format("'{}' of {}", name, isVertex ? "vertices" : "faces"));
      } else {
        imported_.leftOut.addKeyword(kPlyMeshFormat, name);
      }
    }
    if (hasColors) imported_.leftOut.add(isVertex ? "colours of vertices" : "colours of faces", element.count);
  }

  double value(Role role) const { return values_[static_cast<std::size_t>(role)]; }
  const std::vector<double>& list(Role role) const { return lists_[static_cast<std::size_t>(role)]; }

  // Returns the number as an index below `count`; kNone if the number is negative, too large or NaN.
  static std::uint32_t indexOf(double number, std::size_t count) {
    return number >= 0 && number < static_cast<double>(count) ? static_cast<std::uint32_t>(number) : kNone;
  }

  // Adds the triangles of the face that was read last to the part of the face's image.
  void addFace() {
    const std::vector<double>& indices = list(Role::Corners);
    if (indices.size() < 3) return imported_.leftOut.add("faces of fewer than three corners");
    corners_.clear();
    for (const double index : indices) corners_.push_back(indexOf(index, vertices_.size()));
    if (std::ranges::find(corners_, kNone) != corners_.end()) {
      imported_.dropped.outOfRange += corners_.size() - 2;
      return;
    }
    const std::vector<double>& uvs = list(Role::CornerUvs);
    const bool hasUvs = uvs.size() == 2 * corners_.size();
    if (!hasUvs && !uvs.empty()) imported_.leftOut.add("texture coordinates of faces that are not two a corner");
    AssetPart& part = partOf(indexOf(value(Role::Image), images_.size()), hasUvs);
    for (const auto& t : polygons_.divide(corners_.size(), [this](std::size_t i) { return vertices_[corners_[i]]; })) {
      part.triangles.push_back({corners_[t[0]], corners_[t[1]], corners_[t[2]]});
      for (const std::uint32_t corner : t) {
        if (!hasUvs) break;
        part.uvs.push_back({static_cast<float>(uvs[2 * corner]), static_cast<float>(uvs[2 * corner + 1])});
      }
    }
  }

  // Returns the part for faces with this image (its index, or kNone). Faces whose corners have texture coordinates of
  // their own (`hasCornerUvs`) have separate parts.
  AssetPart& partOf(std::uint32_t image, bool hasCornerUvs) {
    const auto [index, isNew] = parts_.try_emplace({image, hasCornerUvs}, imported_.parts.size());
    if (isNew) {
      imported_.parts.emplace_back().materialIndex = static_cast<std::uint32_t>(index->second);
      ImportedMaterial& material = imported_.materials.emplace_back();
      material.stated = false;
      if (image != kNone) {
        material.base.name = images_[image];
        isImageUsed_[image] = true;
      }
    }
    return imported_.parts[index->second];
  }

  // Gives each part its own vertices. Before this call, the triangles of all parts hold the file's vertex indices, and
  // AssetPart::uvs is empty or has an entry for each corner of the part's triangles.
  void addVerticesToParts() {
    placePositions(vertices_, hasExactVertices(), options_, imported_);
    const auto positionOf = [&](const Vec3d& vertex) { return static_cast<Vec3f>(vertex - imported_.origin); };
    for (AssetPart& part : imported_.parts) {
      if (imported_.parts.size() == 1 && part.uvs.empty()) {
        for (const Vec3d& vertex : vertices_) part.positions.push_back(positionOf(vertex));
        part.uvs = std::move(uvs_);
        weld(part);
        continue;
      }
      const bool takesVertexUvs = hasUvs_ && part.uvs.empty();
      for (const Triangle& triangle : std::exchange(part.triangles, {})) {
        for (const std::uint32_t vertex : triangle) {
          part.positions.push_back(positionOf(vertices_[vertex]));
          if (takesVertexUvs) part.uvs.push_back(uvs_[vertex]);
        }
      }
      makeTriangles(part);
    }
  }

  // True if the file has coordinates as doubles or text: relative to an origin, float32 stores them more exactly.
  bool hasExactVertices() const {
    const auto isExact = [](const PlyProperty& p) { return p.name.size() == 1 && p.value.size == 8; };
    const auto vertex = std::ranges::find(header_.elements, "vertex", &PlyElement::name);
    return vertex != header_.elements.end() &&
           (header_.format == PlyHeader::Format::Ascii || std::ranges::any_of(vertex->properties, isExact));
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  PlyHeader header_;
  std::string bytes_;
  PlyBody body_;
  std::array<double, kRoles> values_{};              // the latest number of each role
  std::array<std::vector<double>, kRoles> lists_{};  // the latest list of each role
  std::vector<Vec3d> vertices_;                      // in the file's units and axes, until addVerticesToParts()
  bool hasUvs_ = false;                              // true: vertices have texture coordinates
  std::vector<Vec2f> uvs_;                           // texture coordinates of the vertices
  std::vector<std::string> images_;                  // names of images
  std::vector<bool> isImageUsed_;                    // by image; true: a face shows the image
  // Indices of the parts, by image (kNone: none) and by whether corners have texture coordinates of their own.
  std::map<std::pair<std::uint32_t, bool>, std::size_t> parts_;
  Triangulator polygons_;
  std::vector<std::uint32_t> corners_;  // indices of the vertices of the latest face
  ImportedFile imported_;
};

}  // namespace

const FormatSupport kPlyMeshFormat{
    "PLY of triangles",
    ".ply with faces",
    "Polygons of three corners and more; coordinates in double or text lose no digits. Texture coordinates of "
    "vertices or of corners; a face's image is numbered by texnumber among the comments 'TextureFile NAME'",
    "images that no face shows; textures of parts without texture coordinates; faces of fewer than three corners; "
    "vertices that no face uses, if they are more than half; bytes behind the stated contents; all other properties "
    "and elements",
    {.read = {"vertex face x y z vertex_indices vertex_index s t u v texture_u texture_v texcoord texnumber"},
     .unused = {"nx ny nz normal_x normal_y normal_z quality confidence curvature radius flags camera"},
     .leftOut = {
         {"red green blue alpha r g b a diffuse_red diffuse_green diffuse_blue", "colours of vertices and of faces"},
         {"edge", "elements 'edge'"},
         {"material material_index material_indices", "materials of faces (material_index)"},
         {"label labels category_id objectid object_id instance",
          "columns of labels or instances (without its faces, as a cloud, the file keeps them)"}}}};

ImportedFile readPlyMesh(const std::filesystem::path& file, const AssetOptions& options) {
  return PlyMeshReader(file, options).read();
}

}  // namespace scanmill
