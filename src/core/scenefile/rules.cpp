#include "scenefile/rules.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <re2/re2.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <map>
#include <tuple>

#include "base/terminal.h"

namespace scanmill {
namespace {

// Returns the index after the end of the set that starts with the '[' at glob[open]; `open` if the set has no ']'.
std::size_t endOfSet(std::string_view glob, std::size_t open) {
  const bool negated = open + 1 < glob.size() && (glob[open + 1] == '!' || glob[open + 1] == '^');
  const std::size_t close = glob.find(']', open + (negated ? 3 : 2));  // a ']' that comes first is an item of the set
  return close == std::string_view::npos ? open : close + 1;
}

// Returns the regular expression for a set of a glob, such as [a-z] or [!abc]. `set`: the text from '[' to ']'.
std::string regexOfSet(std::string_view set) {
  const bool negated = set[1] == '!' || set[1] == '^';
  const std::string_view items = set.substr(negated ? 2 : 1, set.size() - (negated ? 3 : 2));
  std::string regex = negated ? "[^" : "[";
  for (std::size_t i = 0; i < items.size();) {
    const std::size_t bytes = utf8At(items, i).bytes;
    const bool isRange = i > 0 && items[i] == '-' && i + 1 < items.size();
    regex += isRange ? "-" : re2::RE2::QuoteMeta(std::string(items.substr(i, bytes)));
    i += bytes;
  }
  return regex + "]";
}

// Returns the indices of the opening brace at glob[open], of its commas and of its closing brace; an empty list if
// there is no closing brace, or nothing between the braces.
std::vector<std::size_t> bracesAt(std::string_view glob, std::size_t open) {
  std::vector<std::size_t> marks{open};
  int depth = 1;
  for (std::size_t i = open + 1; i < glob.size(); ++i) {
    if (glob[i] == '[') i = std::max(endOfSet(glob, i), i + 1) - 1;
    if (glob[i] == '{') ++depth;
    if (glob[i] == '}') --depth;
    if (depth == 0 || (glob[i] == ',' && depth == 1)) marks.push_back(i);
    if (depth == 0) return i == open + 1 ? std::vector<std::size_t>{} : marks;
  }
  return {};
}

// Returns the regular expression that, applied to whole names, matches the same names as a glob. Braces around a text
// without commas may also be ordinary characters of a name: "{a}" matches "a" and "{a}". Braces that are never closed
// are ordinary characters. `depth`: number of braces around the glob.
std::string regexOf(std::string_view glob, int depth, const Location& where) {
  constexpr int kDeepest = 8;
  if (depth > kDeepest) throw InputError(where, "the braces of a pattern are nested more than {} deep", kDeepest);
  std::string regex;
  for (std::size_t i = 0; i < glob.size();) {
    const std::vector<std::size_t> braces = glob[i] == '{' ? bracesAt(glob, i) : std::vector<std::size_t>{};
    const std::size_t setEnd = glob[i] == '[' ? endOfSet(glob, i) : i;
    if (!braces.empty()) {
      std::vector<std::string> alternatives;
      for (std::size_t k = 0; k + 1 < braces.size(); ++k) {
        alternatives.push_back(regexOf(glob.substr(braces[k] + 1, braces[k + 1] - braces[k] - 1), depth + 1, where));
      }
      if (alternatives.size() == 1) alternatives.push_back("\\{" + alternatives.front() + "\\}");
      regex += fmt::format("(?:{})", fmt::join(alternatives, "|"));
      i = braces.back() + 1;
    } else if (setEnd > i) {
      regex += regexOfSet(glob.substr(i, setEnd - i));
      i = setEnd;
    } else {
      regex += glob[i] == '*' ? ".*" : glob[i] == '?' ? "." : re2::RE2::QuoteMeta(std::string(glob.substr(i, 1)));
      ++i;
    }
  }
  return regex;
}

// Returns a compiled pattern from a cache of the thread: compiling costs far more than matching, and all parts of an
// asset are tested with the same few patterns. Throws InputError at `where` for an invalid pattern.
const re2::RE2& compiled(const std::string& pattern, const Location& where) {
  thread_local std::map<std::string, re2::RE2> cache;
  const auto cached = cache.find(pattern);
  if (cached != cache.end()) return cached->second;
  re2::RE2::Options options;
  options.set_log_errors(false);
  options.set_dot_nl(!isRegex(pattern));
  const std::string regex =
      isRegex(pattern) ? pattern.substr(1, pattern.size() - 2) : regexOf(inUtf8(pattern), 0, where);
  const auto entry = cache.try_emplace(pattern, regex, options).first;
  if (entry->second.ok()) return entry->second;
  const std::string error = entry->second.error();
  cache.erase(entry);
  throw InputError(where, "bad pattern {}: {}; {}", pattern, error,
                   isRegex(pattern) ? "the syntax between slashes is that of RE2, which has no look-around and "
                                      "no back-references"
                                    : "a '[' begins a set of characters; write [[] for the character itself");
}

// Returns the pattern that a key gives; an empty text without the key. Throws InputError for an invalid pattern.
std::string readPattern(Fields& conditions, std::string_view key) {
  const Value* value = conditions.find(key);
  if (!value) return {};
  std::string pattern = readText(*value, key);
  if (pattern.empty()) {
    throw InputError(value->where, "the pattern of '{}' is empty; leave it out, or write \"*\"", key);
  }
  compiled(pattern, value->where);
  return pattern;
}

// Reads a colour "#rrggbb". Throws InputError for any other text.
Rgb readColor(const Value& value) {
  const std::string text = value.kind == Value::Kind::Scalar ? value.text : std::string();
  std::uint32_t rgb = 0;
  const bool isHexadecimal =
      text.size() == 7 && text[0] == '#' &&
      std::from_chars(text.data() + 1, text.data() + 7, rgb, 16).ptr == text.data() + text.size();
  if (!isHexadecimal) {
    throw InputError(value.where,
                     "a color must be a text in quotes such as \"#8fb34d\" (red, green, blue): `scanmill info FILE "
                     "--colors` lists the colours of a file");
  }
  return {static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>(rgb >> 8), static_cast<std::uint8_t>(rgb)};
}

// Returns one colour or a list of colours; an empty list if `value` is null.
std::vector<Rgb> readColors(const Value* value) {
  std::vector<Rgb> colors;
  if (value == nullptr) return colors;
  if (value->kind != Value::Kind::Sequence) return {readColor(*value)};
  for (const Value& item : value->items) colors.push_back(readColor(item));
  if (colors.empty()) throw InputError(value->where, "color is an empty list: leave it out");
  return colors;
}

constexpr Range kLengths{-1e7, 1e7};  // m, limits of boxes, heights and sizes; deg, limits of slopes

// Reads a box [[x, y, z], [x, y, z]] (m): its corners with the least and the greatest coordinates; none for null.
std::optional<Box> readBox(const Value* value) {
  if (value == nullptr) return std::nullopt;
  std::vector<std::vector<double>> corners;
  if (value->kind == Value::Kind::Sequence) {
    for (const Value& corner : value->items) corners.push_back(readNumbers(corner, "box", kLengths));
  }
  const auto isCorner = [](const std::vector<double>& c) { return c.size() == 3; };
  if (corners.size() != 2 || !std::ranges::all_of(corners, isCorner)) {
    throw InputError(value->where, "box must be two corners, such as [[0, 0, 0], [9, 9, 3]]");
  }
  const auto point = [&](std::size_t i) { return Vec3d{corners[i][0], corners[i][1], corners[i][2]}; };
  const Box box{point(0), point(1)};
  if (box.low.x > box.high.x || box.low.y > box.high.y || box.low.z > box.high.z) {
    throw InputError(value->where, "the first corner of a box must have the least x, y and z, the second the greatest");
  }
  return box;
}

bool isInside(const Box& box, const Vec3d& p) {
  return box.low.x <= p.x && p.x <= box.high.x && box.low.y <= p.y && p.y <= box.high.y && box.low.z <= p.z &&
         p.z <= box.high.z;
}

// Reads the conditions of a rule: the map `match`.
void readMatch(const Value& match, Rule& rule) {
  Fields fields(match, "match");
  rule.node = readPattern(fields, "node");
  rule.material = readPattern(fields, "material");
  rule.texture = readPattern(fields, "texture");
  rule.file = readPattern(fields, "file");
  rule.colors = readColors(fields.find("color"));
  if (fields.has("within")) {
    if (rule.colors.empty())
      throw InputError(fields.require("within").where,
                       "within needs the key `color`: it is the greatest difference from this color");
    rule.within = static_cast<int>(fields.integer("within", 0, 255));
  }
  rule.box = readBox(fields.find("box"));
  rule.height = fields.range("height", kLengths);
  rule.slope = fields.range("slope_deg", kLengths);
  if (rule.slope) rule.slope = Range{radians(rule.slope->low), radians(rule.slope->high)};
  rule.size = fields.range("size", kLengths);
  fields.finish();
  if (rule.node.empty() && rule.material.empty() && rule.texture.empty() && rule.file.empty() && !rule.byTriangle()) {
    throw InputError(
        match.where,
        "match is empty: give node, material, texture, file, color, box, height, slope_deg or size, or write 'any'");
  }
}

Rule readRule(const Value& value) {
  Fields fields(value, "rule");
  Rule rule{.where = value.where};
  const Value& match = fields.require("match");
  if (match.kind == Value::Kind::Scalar) {
    if (match.text != "any") {
      throw InputError(match.where, "match must be 'any' or a map of patterns such as {{node: \"tree*\"}}, found '{}'",
                       match.text);
    }
  } else {
    readMatch(match, rule);
  }
  rule.className = fields.text("class", "");
  rule.materialName = fields.text("material", "");
  rule.drop = fields.boolean("drop", false);
  fields.finish();
  if (rule.drop && !(rule.className.empty() && rule.materialName.empty())) {
    throw InputError(value.where, "a rule with `drop: true` can have neither class nor material: leave them out");
  }
  if (!rule.drop && rule.className.empty() && rule.materialName.empty()) {
    throw InputError(value.where,
                     "the rule has neither class nor material: give at least one, or `drop: true` to leave out the "
                     "triangles that it matches");
  }
  return rule;
}

}  // namespace

bool isRegex(std::string_view pattern) {
  return pattern.size() > 2 && pattern.front() == '/' && pattern.back() == '/';
}

bool Rule::operator==(const Rule& other) const {
  const auto comparedFields = [](const Rule& r) {
    return std::tie(r.node, r.material, r.texture, r.file, r.colors, r.within, r.box, r.height, r.slope, r.size,
                    r.className, r.materialName, r.drop);
  };
  return comparedFields(*this) == comparedFields(other);
}

std::vector<Rule> readRules(const Value& value) {
  if (value.kind == Value::Kind::Null) return {};
  if (value.kind != Value::Kind::Sequence) throw InputError(value.where, "rules must be a list of rules");
  std::vector<Rule> rules;
  for (const Value& item : value.items) rules.push_back(readRule(item));
  return rules;
}

std::string inUtf8(std::string_view text) {
  std::string utf8;
  for (std::size_t i = 0; i < text.size();) {
    const Utf8Character character = utf8At(text, i);
    if (const auto byte = static_cast<unsigned char>(text[i]); character.code == kNoCharacter) {
      // Codes from 0x80 to 0xFF have two bytes in UTF-8: 110000xx 10xxxxxx.
      utf8 += {static_cast<char>(0xC0 | byte >> 6), static_cast<char>(0x80 | (byte & 0x3F))};
    } else {
      utf8 += text.substr(i, character.bytes);
    }
    i += character.bytes;
  }
  return utf8;
}

bool matches(const std::string& pattern, std::string_view text, const Location& where) {
  const std::string name = inUtf8(text);
  if (!isRegex(pattern) && pattern.find_first_of("*?[{") == std::string::npos) return name == inUtf8(pattern);
  const auto anchor = isRegex(pattern) ? re2::RE2::UNANCHORED : re2::RE2::ANCHOR_BOTH;
  return compiled(pattern, where).Match(name, 0, name.size(), anchor, nullptr, 0);
}

std::optional<std::string> matchedText(const std::string& pattern, std::string_view text, const Location& where) {
  const re2::RE2& expression = compiled(pattern, where);
  const std::string name = inUtf8(text);
  re2::StringPiece groups[2];  // the complete match, and the first group
  const int groupCount = expression.NumberOfCapturingGroups() > 0 ? 2 : 1;
  if (!expression.Match(name, 0, name.size(), re2::RE2::UNANCHORED, groups, groupCount)) return std::nullopt;
  return std::string(groups[groupCount - 1]);
}

std::string_view textureName(std::string_view path) {
  const std::size_t last = path.find_last_of("/\\");
  return last == std::string_view::npos ? path : path.substr(last + 1);
}

bool matchesNames(const Rule& rule, const Names& names) {
  const auto matchesName = [&](const std::string& pattern, std::string_view text) {
    return pattern.empty() || matches(pattern, text, rule.where);
  };
  std::string path(names.texture);
  std::ranges::replace(path, '\\', '/');
  const bool testsPath = isRegex(rule.texture) || rule.texture.find('/') != std::string::npos;
  return matchesName(rule.node, names.node) && matchesName(rule.material, names.material) &&
         matchesName(rule.texture, testsPath ? path : textureName(path)) && matchesName(rule.file, names.file);
}

bool matchesTriangle(const Rule& rule, const TriangleTraits& traits) {
  const auto isNear = [&](const Rgb& color) {
    for (std::size_t c = 0; c < color.size(); ++c) {
      if (std::abs(int{color[c]} - int{traits.color[c]}) > rule.within) return false;
    }
    return true;
  };
  return (rule.colors.empty() || std::ranges::any_of(rule.colors, isNear)) &&
         (!rule.box || isInside(*rule.box, traits.middle)) && (!rule.height || rule.height->contains(traits.height)) &&
         (!rule.slope || rule.slope->contains(traits.slope)) && (!rule.size || rule.size->contains(traits.size));
}

std::string describe(const Rule& rule) {
  std::vector<std::string> terms;
  for (const auto& [key, pattern] : {std::pair{"node", &rule.node},
                                     {"material", &rule.material},
                                     {"texture", &rule.texture},
                                     {"file", &rule.file}}) {
    if (!pattern->empty()) terms.push_back(fmt::format("{}: {}", key, *pattern));
  }
  if (!rule.colors.empty()) {
    std::vector<std::string> hexadecimal;
    for (const Rgb& c : rule.colors) hexadecimal.push_back(fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]));
    terms.push_back(fmt::format("color: {}", fmt::join(hexadecimal, " ")));
  }
  if (rule.box) {
    const auto& [low, high] = *rule.box;
    terms.push_back(fmt::format("box: {:g} {:g} {:g} to {:g} {:g} {:g}", low.x, low.y, low.z, high.x, high.y, high.z));
  }
  if (rule.height) terms.push_back(fmt::format("height: {:g} to {:g}", rule.height->low, rule.height->high));
  if (rule.slope) {
    terms.push_back(fmt::format("slope_deg: {:g} to {:g}", degrees(rule.slope->low), degrees(rule.slope->high)));
  }
  if (rule.size) terms.push_back(fmt::format("size: {:g} to {:g}", rule.size->low, rule.size->high));
  return terms.empty() ? "any" : fmt::format("{}", fmt::join(terms, ", "));
}

}  // namespace scanmill
