#pragma once

// The rules of a scene file, which give the parts of an asset their classes and materials. The first matching rule
// wins.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "config/fields.h"
#include "config/value.h"

namespace scanmill {

using Rgb = std::array<std::uint8_t, 3>;  // red, green and blue (sRGB)

// In YAML: {match: {node: "House*Mesh", material: roof, texture: "*{leaf,bark}*", file: "/car_[0-9]+/"}, class:
// building, material: roof_tile}. A pattern is a glob (*, ?, [a-z], {one,another}), which must match the whole name and
// is case-sensitive; or, between slashes, a regular expression of RE2, which must match some part of the name. A
// glob of `texture` without a slash is compared with the file name alone, without its folders. Other keys test single
// triangles: {color: "#8fb34d", within: 16, box: [[0, 0, 0], [9, 9, 3]], height: [0, 2.5], slope_deg: [0, 30], size:
// [1, 6]}. All conditions of a match must hold; `match: any` always holds. A rule without a class sets only the
// material, and the search for a class goes on; a rule without a material sets only the class. `drop: true` in place of
// a class leaves the triangles out.
struct Rule {
  Location where;
  std::string node, material, texture, file;  // patterns of names; empty: any name matches
  std::vector<Rgb> colors;                    // sRGB; the base colour at the triangle's centre must be near one of them
  int within = 16;                            // largest difference from a colour in red, green or blue (0 to 255)
  std::optional<Box> box;                     // m, asset frame; the triangle's centre must be in the box
  std::optional<Range> height;                // m, of the triangle's centre above the asset's lowest point
  std::optional<Range> slope;                 // rad, between the triangle and the horizontal
  std::optional<Range> size;                  // m, longest edge of the box around the triangle's connected part
  std::string className, materialName;        // empty: the rule does not set it
  bool drop = false;

  // Returns true if the rule tests single triangles, and not only names.
  bool byTriangle() const { return !colors.empty() || box || height || slope || size; }
  bool decides() const { return drop || !className.empty(); }
  bool operator==(const Rule& other) const;  // compares everything except `where`
};

// Reads a list of rules. Throws InputError with the place.
std::vector<Rule> readRules(const Value& value);

// Returns a text that describes a rule's conditions, such as "node: Wall*, height: 0 to 2.5".
std::string describe(const Rule& rule);

// Returns the file name at the end of a texture's path, whose folders are separated by slashes or backslashes.
std::string_view textureName(std::string_view path);

// Names of a part, for comparison with the patterns of rules. A name that the part does not have is empty.
struct Names {
  std::string_view node, material, texture, file;
};
bool matchesNames(const Rule& rule, const Names& names);

struct TriangleTraits {
  Rgb color{};
  Vec3d middle;       // m, in the asset's frame
  double height = 0;  // m, above the asset's lowest point
  double slope = 0;   // rad, from horizontal
  double size = 0;    // m, longest edge of the box around the connected part
};
bool matchesTriangle(const Rule& rule, const TriangleTraits& traits);

// Returns the text with Latin-1 characters in place of bytes that are not UTF-8. Patterns are compared with this text.
std::string inUtf8(std::string_view text);

// True if a pattern is a /regular expression/; else it is a glob.
bool isRegex(std::string_view pattern);

// Returns true if a text matches a pattern. Throws InputError at `where` for an invalid pattern.
bool matches(const std::string& pattern, std::string_view text, const Location& where);

// Returns the text that the first group of a /regular expression/ matches, or the complete match if the expression has
// no group; nothing if the expression does not match. Throws InputError at `where` for an invalid regular expression.
std::optional<std::string> matchedText(const std::string& pattern, std::string_view text, const Location& where);

}  // namespace scanmill
