// Reads the polygons of Wavefront OBJ files ("Appendix B1. Object Files (.obj)" of the Advanced Visualizer's manual),
// with coordinates in double precision.
//
//   v x y z [w] [r g b [a]]    a vertex; its weight and its colour are not used
//   vt u [v [w]]               texture coordinates
//   f v[/vt][/vn] ...          a polygon; negative indices count from the latest vertex
//   o NAME, g NAME             the node of the faces that follow: the group if there is one, else the object
//   usemtl NAME, mtllib FILE   materials; a line may name several libraries
//
// Also reads their material libraries: "Appendix B2. Material Library File Format (.mtl)", with the physically based
// keys Pr and Pm.
//
//   newmtl NAME
//   Kd r [g b]                       base colour, linear; a single number is grey; with neither Kd nor map_Kd a
//                                    material states no colour
//   d [-halo] F, Tr F                opacity, or 1 - opacity
//   Pr F, Pm F                       roughness, metallic
//   map_Kd, map_d [options] FILE     image of the base colour, or of the opacity; the name may contain spaces
//
// The options -s and -o scale and shift the texture coordinates. If a material has both images, map_Kd's options hold
// for both. Other keys do not say how a surface reflects in the near infrared.

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
#include "assets/meshes/base_color.h"
#include "assets/meshes/imported_file.h"
#include "assets/meshes/polygon.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "base/file.h"
#include "base/format_support.h"
#include "base/text_scan.h"

namespace scanmill {

namespace {

namespace fs = std::filesystem;

// Reads the statements of an OBJ file or a material library, one after the other. A statement is a line: a keyword and
// its values. A line that ends with a backslash continues in the next line. Lines that begin with # are comments.
class Statements {
 public:
  // `text` must outlive the object.
  Statements(std::string_view text, const fs::path& file) : text_(textOfFile(text)), file_(file.string()) {}

  // Goes to the next statement. Returns false at the end of the text.
  bool next() {
    while (!text_.empty()) {
      std::string_view line = nextLine();
      line_ = lines_;
      if (line.empty() || line.front() == '#') continue;
      if (line.back() == '\\') {
        joined_.clear();
        for (; !line.empty() && line.back() == '\\'; line = nextLine()) {
          joined_.append(trimmed(line.substr(0, line.size() - 1))).append(" ");
        }
        joined_.append(line);
        line = trimmed(joined_);
        if (line.empty()) continue;
      }
      keyword_ = takeWord(line);
      rest_ = trimmed(line);
      return true;
    }
    return false;
  }

  std::string_view keyword() const { return keyword_; }
  // Returns the line after the keyword, without blanks at both ends but with any comment, since names may contain #.
  std::string_view rest() const { return rest_; }
  // Splits the line behind the keyword, up to a comment, into words. The result is valid until the next call.
  const std::vector<std::string_view>& words() {
    // A # after a full stop starts no comment: Microsoft's library prints NaN as "-1.#IND".
    std::size_t comment = rest_.find('#');
    while (comment != rest_.npos && comment > 0 && rest_[comment - 1] == '.') comment = rest_.find('#', comment + 1);
    splitWords(rest_.substr(0, comment), words_);
    return words_;
  }

  // Converts a word to a number, which may be "nan" or "inf". Throws InputError with the line.
  double number(std::string_view word) const {
    double number = 0;
    if (parseNumber(word, number)) return number;
    fail(fmt::format("'{}' is not a number{}", word.substr(0, 40),
                     word.find(',') == std::string_view::npos ? "" : ": write decimal points, not commas"));
  }
  // Throws an InputError that names file, line and keyword.
  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError({file_, line_}, "{}: {}", keyword_.substr(0, 40), problem);
  }

 private:
  // Takes the next line of the text, and counts it.
  std::string_view nextLine() {
    ++lines_;
    return takeLine(text_);
  }

  std::string_view text_;  // the lines that are not read yet
  std::string file_;
  int lines_ = 0;       // number of lines read so far
  int line_ = 0;        // line of the statement, counted from 1
  std::string joined_;  // the text of a statement of several lines
  std::string_view keyword_, rest_;
  std::vector<std::string_view> words_;
};

// Options of images, and the greatest number of values that each takes.
struct ImageOptions {
  std::string_view names;
  int mostValues;
};
constexpr std::array<ImageOptions, 3> kImageOptions{
    {{"-blendu -blendv -boost -texres -clamp -bm -imfchan -type -cc", 1}, {"-mm", 2}, {"-o -s -t", 3}}};

// Options with their default values.
constexpr std::array<std::string_view, 6> kDefaults{"-blendu on", "-blendv on", "-clamp off",
                                                    "-imfchan m", "-mm 0 1",    "-bm 1"};

bool isNumber(std::string_view word) {
  return !word.empty() && word.find_first_not_of("+-.0123456789eE") == std::string_view::npos;
}

// Returns the last number of a statement, as a float.
float lastNumber(Statements& statements) {
  const auto& words = statements.words();
  if (words.empty()) statements.fail("has no value");
  return static_cast<float>(statements.number(words.back()));
}

void readColor(Statements& statements, ImportedMaterial& material) {
  const auto& words = statements.words();
  if (words.size() != 1 && words.size() < 3) statements.fail("give three numbers (red, green, blue)");
  material.stated = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const double value = statements.number(words[words.size() == 1 ? 0 : k]);
    material.color[k] = fraction(static_cast<float>(value), 1.0f);
  }
}

struct ImageOption {
  std::string text;             // the name and the values, as in kDefaults
  std::vector<double> numbers;  // the values that are numbers
};

// Takes the values of an option from `unread`, the text after its name. An option that can take several values may have
// fewer: a word that is no number, or the last word of the line, is then the name of the image.
ImageOption takeValues(const Statements& statements, std::string_view name, int mostValues, std::string_view& unread) {
  ImageOption option{std::string(name), {}};
  for (int i = 0; i < mostValues; ++i) {
    std::string_view textBehind = unread;
    const std::string_view word = takeWord(textBehind);
    if (mostValues > 1 && (!isNumber(word) || trimmed(textBehind).empty())) break;
    if (isNumber(word)) option.numbers.push_back(statements.number(word));
    option.text += isNumber(word) ? fmt::format(" {:g}", option.numbers.back()) : fmt::format(" {}", word);
    unread = trimmed(textBehind);
  }
  return option;
}

// Reads the options and the name of an image into `map`. -s and -o set UvPlacement. Counts other options unless they
// have their default values. Throws InputError if the name is missing.
void readImage(const Statements& statements, ImportedMap& map, LeftOut& leftOut) {
  std::string_view unread = statements.rest();
  while (unread.starts_with('-')) {
    std::string_view textBehind = unread;
    const std::string_view name = takeWord(textBehind);
    const auto row = std::ranges::find_if(
        kImageOptions, [&](const ImageOptions& options) { return containsWord(options.names, name); });
    if (row == kImageOptions.end()) break;
    unread = trimmed(textBehind);
    const ImageOption option = takeValues(statements, name, row->mostValues, unread);
    const auto numberOr = [&](std::size_t index, float fallback) {
      return index < option.numbers.size() ? static_cast<float>(option.numbers[index]) : fallback;
    };
    if (name == "-s") {
      map.placement.scale = {numberOr(0, 1), numberOr(1, 1)};
    } else if (name == "-o") {
      map.placement.offset = {numberOr(0, 0), numberOr(1, 0)};
    } else if (std::ranges::find(kDefaults, option.text) == kDefaults.end()) {
      leftOut.add(fmt::format("options of images ({})", name));
    }
  }
  if (unread.empty()) statements.fail("names no image");
  map.name = std::string(unread);
}

// Reads a statement of a material. Counts statements other than those handled here in `leftOut`.
void readKey(Statements& statements, ImportedMaterial& material, LeftOut& leftOut) {
  const std::string_view key = statements.keyword();
  if (key == "Kd") {
    readColor(statements, material);
  } else if (key == "d") {
    material.opacity = fraction(lastNumber(statements), 1.0f);
  } else if (key == "Tr") {
    material.opacity = 1 - fraction(lastNumber(statements), 0.0f);
  } else if (key == "Pr") {
    material.roughness = fraction(lastNumber(statements), 1.0f);
  } else if (key == "Pm") {
    material.metallic = fraction(lastNumber(statements), 0.0f);
  } else if (key == "map_Kd" || key == "map_kd") {
    readImage(statements, material.base, leftOut);
  } else if (key == "map_d" || key == "map_opacity") {
    readImage(statements, material.opacityMap, leftOut);
  } else {
    leftOut.add(fmt::format("{} of materials", key.substr(0, 40)));
  }
}

struct ObjMaterial : ImportedMaterial {
  bool defined = false;  // false: faces name the material, but no library that was read so far defines it
};

struct Materials {
  std::vector<ObjMaterial> list;
  std::map<std::string, std::size_t> byName;
  LeftOut leftOut;

  // Returns the index of the material; adds a material without a colour if the name is unknown.
  std::size_t indexOf(const std::string& name) {
    const auto [entry, isNew] = byName.try_emplace(name, list.size());
    if (isNew) {
      list.emplace_back().name = name;
      list.back().stated = false;
    }
    return entry->second;
  }
  // Must be called after all libraries are read. Counts materials that place their two images differently and, if the
  // file has libraries and none is missing (`isComplete`), materials that faces name but no library defines.
  void check(bool isComplete) {
    for (const ObjMaterial& material : list) {
      if (!material.defined && !material.name.empty())
        leftOut.add("materials that no library defines (they have the default reflectance)", isComplete ? 1 : 0);
      const bool hasBothImages = !material.base.name.empty() && !material.opacityMap.name.empty();
      if (hasBothImages && material.base.placement != material.opacityMap.placement) {
        leftOut.add("placements of map_d (-s, -o) that differ from that of map_Kd");
      }
    }
  }
};

// Reads a library and adds its materials. If a name is defined twice, the first definition counts; programs differ in
// this. Throws InputError with the line of a statement that cannot be read.
void readMaterials(const fs::path& file, Materials& materials) {
  const std::string text = readFile(file);
  Statements statements(text, file);
  ObjMaterial* material = nullptr;  // material of the statements that follow
  bool isRepeated = false;          // true: the material was defined before, so that this definition is skipped
  while (statements.next()) {
    if (statements.keyword() == "newmtl") {
      material = &materials.list[materials.indexOf(std::string(statements.rest()))];
      isRepeated = std::exchange(material->defined, true);
      if (isRepeated) materials.leftOut.add("further definitions of materials (the first of a name counts)");
    } else if (kObjFormat.useOf(statements.keyword()) != FormatSupport::Use::Unused) {
      if (material == nullptr) statements.fail("stands before the first newmtl");
      if (!isRepeated) readKey(statements, *material, materials.leftOut);
    }
  }
}

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
    for (ObjMaterial& material : materials_.list) imported_.materials.push_back(std::move(material));
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
    if (libraries_.insert(path).second) readMaterials(path, materials_);
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
  Materials materials_;
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
