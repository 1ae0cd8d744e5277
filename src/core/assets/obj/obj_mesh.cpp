#include "assets/obj/obj_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/asset_parts.h"
#include "assets/obj/materials.h"
#include "assets/obj/polygon.h"
#include "assets/obj/statements.h"
#include "assets/references.h"
#include "base/error.h"
#include "base/file.h"
#include "base/grouped.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;
using obj::Statements;

// Largest sum of squared corner counts over all polygons: triangulating a polygon takes a time that grows with the
// square of its corners, some seconds for 60,000 corners.
constexpr double kMostCornersSquared = 4e9;

// Statements without influence on surfaces.
constexpr std::array<std::string_view, 14> kUnused{"vn",        "s",        "mg",     "lod",    "bevel",
                                                   "c_interp",  "d_interp", "maplib", "usemap", "shadow_obj",
                                                   "trace_obj", "call",     "csh",    "end"};

// What is left out, by statement: what it is called in the warning. Other statements are named by their keyword.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kLeftOut{{{"l", "lines (l)"},
                                                                                 {"p", "points (p)"},
                                                                                 {"surf", "free-form surfaces (surf)"},
                                                                                 {"curv", "curves (curv)"},
                                                                                 {"curv2", "curves (curv2)"}}};

// Statements that belong to free-form curves and surfaces, which are counted by surf, curv and curv2.
constexpr std::array<std::string_view, 14> kOfFreeForms{"vp",   "deg",  "bmat", "step", "cstype", "parm",  "trim",
                                                        "hole", "scrv", "sp",   "con",  "ctech",  "stech", "res"};

template <class List>
bool contains(const List& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

class Reader {
 public:
  Reader(const fs::path& file, const AssetOptions& options)
      : file_(file), options_(options), text_(readFile(file)), statements_(text_, file) {
    if (text_.starts_with("\xFE\xFF") || text_.starts_with("\xFF\xFE")) {
      fail("is UTF-16 text: save it as UTF-8, for example with 'iconv -f UTF-16 -t UTF-8'");
    }
  }

  ImportedFile read() {
    while (statements_.next()) readStatement();
    ImportedFile read;
    read.up = options_.up.value_or('z');
    assetFromFile_ = zUpFrom(read.up) * Mat3::scale(Vec3d{1, 1, 1} * options_.metresPerUnit);
    read.origin = origin();
    for (Part& part : parts_) addPart(read, part);
    read.outOfRange = outOfRange_;
    read.materials = std::move(library_.materials);
    read.missing = std::move(missing_);
    tellWhatIsLeftOut();
    return read;
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
      if (key == "o") object_ = statements_.rest();
      group_ = key == "g" ? statements_.rest() : std::string_view();
      part_ = nullptr;
    } else if (key == "usemtl") {
      useMaterial();
    } else if (key == "mtllib") {
      readLibraries();
    } else if (!contains(kUnused, key)) {
      leaveOut(key);
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
      outOfRange_ += face_.size() - 2;
      return;
    }
    triangles_ += face_.size() - 2;
    if (triangles_ > kMostTriangles) fail(fmt::format("has more than {} triangles: split it", kMostTriangles));
    Part& part = currentPart();
    if (face_.size() == 3) {
      part.triangles.push_back({face_[0], face_[1], face_[2]});
      return;
    }
    cornersSquared_ += static_cast<double>(face_.size()) * static_cast<double>(face_.size());
    if (cornersSquared_ > kMostCornersSquared) {
      fail(
          fmt::format("has polygons of up to {} corners, which would take minutes to divide into triangles: export it "
                      "with triangles",
                      face_.size()));
    }
    polygon_.clear();
    for (const Corner& c : face_) polygon_.push_back(vertices_[c.vertex]);
    cut_.clear();
    obj::triangulate(polygon_, cut_);
    for (const auto& t : cut_) part.triangles.push_back({face_[t[0]], face_[t[1]], face_[t[2]]});
  }

  Part& currentPart() {
    if (part_ != nullptr) return *part_;
    const std::pair<std::string, std::string> names{object_, group_};
    const auto node = nodes_.try_emplace(names, static_cast<std::uint32_t>(nodes_.size() + 1)).first->second;
    const std::pair<std::uint32_t, std::size_t> key{node, material()};
    const auto [at, isNew] = partOf_.try_emplace(key, parts_.size());
    if (isNew) parts_.push_back({group_.empty() ? object_ : group_, node, key.second, {}});
    return *(part_ = &parts_[at->second]);
  }

  // Returns the index of the material of the faces that follow.
  std::size_t material() {
    const auto [at, isNew] = library_.byName.try_emplace(material_, library_.materials.size());
    if (isNew) {
      library_.materials.emplace_back().name = material_;
      library_.materials.back().stated = !material_.empty();
      library_.uvs.emplace_back();
    }
    return at->second;
  }

  void useMaterial() {
    material_ = statements_.rest();
    part_ = nullptr;
  }

  // The rest of the line is one name with spaces, or several names.
  void readLibraries() {
    const std::string whole(statements_.rest());
    if (whole.empty()) statements_.fail("names no file");
    std::error_code ignored;
    if (statements_.words().size() == 1 || fs::exists(pathOf(whole), ignored)) return readLibrary(whole);
    const std::vector<std::string_view> names = statements_.words();
    if (std::none_of(names.begin(), names.end(),
                     [&](std::string_view name) { return fs::exists(pathOf(std::string(name)), ignored); })) {
      return readLibrary(whole);
    }
    for (const std::string_view name : names) readLibrary(std::string(name));
  }

  fs::path pathOf(std::string name) const {
    std::replace(name.begin(), name.end(), '\\', '/');
    return fs::absolute(file_).parent_path() / name;
  }

  void readLibrary(const std::string& name) {
    std::error_code ignored;
    fs::path path = pathOf(name);
    if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) {
      fail(fmt::format("names '{}', which is not a file", name));
    }
    if (fs::exists(path, ignored) && !options_.allowOutside &&
        leadsOutside(path.lexically_relative(fs::absolute(file_).parent_path()).string())) {
      fail(refusalOf(name));
    }
    if (!fs::exists(path, ignored)) {
      // Exporters that rename the mesh leave the old name in it.
      path = fs::absolute(file_).replace_extension(".mtl");
      if (!fs::is_regular_file(path, ignored)) {
        if (!contains(missing_, name)) missing_.push_back(name);
        return;
      }
    }
    obj::readLibrary(path, library_);
  }

  void leaveOut(std::string_view key) {
    if (contains(kOfFreeForms, key)) return;
    const auto named =
        std::find_if(kLeftOut.begin(), kLeftOut.end(), [&](const auto& each) { return each.first == key; });
    if (named == kLeftOut.end() && statements_.rest().empty() && triangles_ == 0 && vertices_.empty()) {
      statements_.fail("is no statement of an OBJ file: is it text?");
    }
    ++leftOut_[named != kLeftOut.end() ? std::string(named->second)
                                       : fmt::format("statements '{}'", key.substr(0, 40))];
  }

  void tellWhatIsLeftOut() const {
    std::map<std::string, std::size_t> all = leftOut_;
    all.insert(library_.leftOut.begin(), library_.leftOut.end());
    if (colored_ > 0) all["colours of vertices"] = colored_;
    if (all.empty()) return;
    std::string text;
    for (const auto& [what, count] : all)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", grouped(count), what);
    warn(fmt::format("{}: left out: {}", file_.string(), text));
  }

  // Returns an origin near most vertices (m, along the asset's axes): the median of at most 2000 vertices.
  Vec3d origin() const {
    std::vector<Vec3d> places;
    const std::size_t every = std::max<std::size_t>(vertices_.size() / 1000, 1);
    for (std::size_t i = 0; i < vertices_.size(); i += every) places.push_back(assetFromFile_ * vertices_[i]);
    return originNear(places);
  }

  void addPart(ImportedFile& read, Part& from) const {
    ImportedPart& part = read.parts.emplace_back();
    part.node = std::move(from.node);
    part.nodeIndex = from.nodeIndex;
    part.material = static_cast<std::uint32_t>(from.material);
    const obj::UvPlace& place = library_.uvs[from.material];
    const bool hasUvs = std::any_of(from.triangles.begin(), from.triangles.end(), [](const auto& t) {
      return t[0].uv != kNone || t[1].uv != kNone || t[2].uv != kNone;
    });
    for (const std::array<Corner, 3>& triangle : from.triangles) {
      const auto first = static_cast<std::uint32_t>(part.positions.size());
      part.triangles.push_back({first, first + 1, first + 2});
      for (const Corner& corner : triangle) {
        part.positions.push_back(static_cast<Vec3f>(assetFromFile_ * vertices_[corner.vertex] - read.origin));
        if (!hasUvs) continue;
        const Vec2f uv = corner.uv == kNone ? Vec2f{} : uvs_[corner.uv];
        part.uvs.push_back({uv.x * place.scale.x + place.offset.x, uv.y * place.scale.y + place.offset.y});
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
  std::map<std::pair<std::string, std::string>, std::uint32_t> nodes_;   // index of the node of an object and a group
  std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> partOf_;  // index of the part of a node and a material
  std::vector<Part> parts_;
  Part* part_ = nullptr;  // part of the faces that follow; null: not looked up yet
  obj::Materials library_;
  std::vector<std::string> missing_;            // libraries that do not exist
  std::map<std::string, std::size_t> leftOut_;  // number of statements that are left out, by what they are
  std::size_t colored_ = 0;                     // number of vertices with a colour
  std::uint64_t triangles_ = 0;
  std::uint64_t outOfRange_ = 0;
  double cornersSquared_ = 0;
  std::vector<Corner> face_;
  std::vector<Vec3d> polygon_;
  std::vector<std::array<std::uint32_t, 3>> cut_;
};

}  // namespace

ImportedFile readObjMesh(const std::filesystem::path& file, const AssetOptions& options) {
  return Reader(file, options).read();
}

}  // namespace scanmill
