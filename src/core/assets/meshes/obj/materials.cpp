#include "assets/meshes/obj/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "assets/meshes/base_color.h"
#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"

namespace scanmill::obj {

namespace {

// Options of images, and the greatest number of values that each takes.
struct ImageOptions {
  std::string_view names;  // with blanks around them
  int values;
};
constexpr std::array<ImageOptions, 3> kImageOptions{
    {{" -blendu -blendv -boost -texres -clamp -bm -imfchan -type -cc ", 1}, {" -mm ", 2}, {" -o -s -t ", 3}}};

// Options with the values that they have by default.
constexpr std::array<std::string_view, 6> kDefaults{"-blendu on", "-blendv on", "-clamp off",
                                                    "-imfchan m", "-mm 0 1",    "-bm 1"};

bool isNumber(std::string_view word) {
  return !word.empty() && word.find_first_not_of("+-.0123456789eE") == std::string_view::npos;
}

class Library {
 public:
  Library(std::string_view text, const std::filesystem::path& file, Materials& materials)
      : statements_(text, file), to_(materials) {}

  void read() {
    while (statements_.next()) {
      const std::string_view key = statements_.keyword();
      if (key == "newmtl") {
        begin();
      } else if (!objFormat().has(FormatElements::Use::Unused, key)) {
        if (index_ == kNone) statements_.fail("stands before the first newmtl");
        if (!known_) readKey(key);
      }
    }
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  void begin() {
    index_ = to_.indexOf(std::string(statements_.rest()));
    known_ = std::exchange(to_.list[index_].defined, true);
    if (known_) to_.leftOut.add("further definitions of materials (the first of a name counts)");
  }

  ImportedMaterial& material() { return to_.list[index_]; }

  void readKey(std::string_view key) {
    if (key == "Kd") {
      readColor();
    } else if (key == "d") {
      material().opacity = fraction(static_cast<float>(last()), 1.0f);
    } else if (key == "Tr") {
      material().opacity = 1 - fraction(static_cast<float>(last()), 0.0f);
    } else if (key == "Pr") {
      material().roughness = fraction(static_cast<float>(last()), 1.0f);
    } else if (key == "Pm") {
      material().metallic = fraction(static_cast<float>(last()), 0.0f);
    } else if (key == "map_Kd" || key == "map_kd") {
      material().base = readImage(material().base.placement);
    } else if (key == "map_d" || key == "map_opacity") {
      material().opacityMap = readImage(material().opacityMap.placement);
    } else {
      to_.leftOut.add(fmt::format("{} of materials", key.substr(0, 40)));
    }
  }

  double last() {
    const auto& words = statements_.words();
    if (words.empty()) statements_.fail("has no value");
    return statements_.number(words.back());
  }

  void readColor() {
    const auto& words = statements_.words();
    if (words.size() != 1 && words.size() < 3) statements_.fail("give three numbers (red, green, blue)");
    material().stated = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = statements_.number(words[words.size() == 1 ? 0 : k]);
      material().color[k] = fraction(static_cast<float>(value), 1.0f);
    }
  }

  // Reads options and the name of an image. The options -s and -o change `placement`; others are counted unless they
  // are as by default.
  ImportedMap readImage(const UvPlacement& placement) {
    std::string_view rest = statements_.rest();
    ImportedMap map;
    map.placement = placement;
    while (rest.starts_with('-')) {
      std::string_view behind = rest;
      const std::string_view name = takeWord(behind);
      const auto option = std::find_if(kImageOptions.begin(), kImageOptions.end(),
                                       [between = fmt::format(" {} ", name)](const ImageOptions& row) {
                                         return row.names.find(between) != std::string_view::npos;
                                       });
      if (option == kImageOptions.end()) break;
      rest = trimmed(behind);
      std::array<std::optional<double>, 3> values;
      std::string given(name);
      for (int i = 0; i < option->values; ++i) {
        std::string_view next = rest;
        const std::string_view word = takeWord(next);
        const bool number = isNumber(word);
        if (option->values > 1 && (!number || trimmed(next).empty())) break;
        auto& value = values[static_cast<std::size_t>(i)];
        if (number) value = statements_.number(word);
        given += number ? fmt::format(" {:g}", *value) : fmt::format(" {}", word);
        rest = trimmed(next);
      }
      if (name == "-s") {
        map.placement.scale = {floatOr(values[0], 1), floatOr(values[1], 1)};
      } else if (name == "-o") {
        map.placement.offset = {floatOr(values[0], 0), floatOr(values[1], 0)};
      } else if (std::find(kDefaults.begin(), kDefaults.end(), given) == kDefaults.end()) {
        to_.leftOut.add(fmt::format("options of images ({})", name));
      }
    }
    if (rest.empty()) statements_.fail("names no image");
    map.name = std::string(rest);
    return map;
  }

  static float floatOr(const std::optional<double>& value, float fallback) {
    return value ? static_cast<float>(*value) : fallback;
  }

  Statements statements_;
  Materials& to_;
  std::size_t index_ = kNone;
  bool known_ = false;  // true: the material was defined before, so that this definition is skipped
};

}  // namespace

std::size_t Materials::indexOf(const std::string& name) {
  const auto [at, isNew] = byName.try_emplace(name, list.size());
  if (isNew) {
    list.emplace_back().name = name;
    list.back().stated = false;
  }
  return at->second;
}

void Materials::check(bool allRead) {
  for (const ObjMaterial& material : list) {
    if (!material.defined && !material.name.empty())
      leftOut.add("materials that no library defines (they have the default reflectance)", allRead ? 1 : 0);
    const bool bothImages = !material.base.name.empty() && !material.opacityMap.name.empty();
    if (bothImages && material.base.placement != material.opacityMap.placement) {
      leftOut.add("placements of map_d (-s, -o) that differ from that of map_Kd");
    }
  }
}

void readLibrary(const std::filesystem::path& file, Materials& materials) {
  const std::string text = readFile(file);
  Library(text, file, materials).read();
}

Statements::Statements(std::string_view text, const std::filesystem::path& file)
    : text_(textOfFile(text)), file_(file.string()) {}

std::string_view Statements::nextLine() {
  ++lines_;
  return takeLine(text_);
}

bool Statements::next() {
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

const std::vector<std::string_view>& Statements::words() {
  // "-1.#IND", as Microsoft's library prints NaN, is no number with a comment.
  std::size_t comment = rest_.find('#');
  while (comment != rest_.npos && comment > 0 && rest_[comment - 1] == '.') comment = rest_.find('#', comment + 1);
  splitWords(rest_.substr(0, comment), words_);
  return words_;
}

double Statements::number(std::string_view word) const {
  double number = 0;
  if (parseNumber(word, number)) return number;
  fail(fmt::format("'{}' is not a number{}", word.substr(0, 40),
                   word.find(',') == std::string_view::npos ? "" : ": write decimal points, not commas"));
}

void Statements::fail(const std::string& what) const {
  throw InputError({file_, line_}, fmt::format("{}: {}", keyword_.substr(0, 40), what));
}

}  // namespace scanmill::obj
