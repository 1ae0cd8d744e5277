#include "assets/meshes/obj/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "assets/meshes/base_color.h"
#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"

namespace scanmill::obj {

namespace {

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

}  // namespace

std::size_t Materials::indexOf(const std::string& name) {
  const auto [entry, isNew] = byName.try_emplace(name, list.size());
  if (isNew) {
    list.emplace_back().name = name;
    list.back().stated = false;
  }
  return entry->second;
}

void Materials::check(bool isComplete) {
  for (const ObjMaterial& material : list) {
    if (!material.defined && !material.name.empty())
      leftOut.add("materials that no library defines (they have the default reflectance)", isComplete ? 1 : 0);
    const bool hasBothImages = !material.base.name.empty() && !material.opacityMap.name.empty();
    if (hasBothImages && material.base.placement != material.opacityMap.placement) {
      leftOut.add("placements of map_d (-s, -o) that differ from that of map_Kd");
    }
  }
}

void readLibrary(const std::filesystem::path& file, Materials& materials) {
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
  // A # after a full stop starts no comment: Microsoft's library prints NaN as "-1.#IND".
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

void Statements::fail(const std::string& problem) const {
  throw InputError({file_, line_}, "{}: {}", keyword_.substr(0, 40), problem);
}

}  // namespace scanmill::obj
