#pragma once

// The rules of a scene file, which give the parts of an asset their classes and materials. The first that matches wins.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

using Rgb = std::array<std::uint8_t, 3>;  // sRGB

struct Between {
  double low = 0, high = 0;
  bool holds(double value) const { return low <= value && value <= high; }
};

// In YAML: {match: {node: "House*Mesh", material: roof, texture: "*{leaf,bark}*", file: "/car_[0-9]+/"}, class:
// building, material: roof_tile}. A pattern is a glob (*, ?, [a-z], {one,another}), which must match the whole name and
// is case-sensitive; or, between slashes, an ECMAScript regular expression, which must match some part of the name. A
// glob of `texture` without a slash is compared with the file name alone, without its folders. Other keys test single
// triangles: {color: "#8fb34d", within: 16, box: [[0, 0, 0], [9, 9, 3]], height: [0, 2.5], slope_deg: [0, 30], size:
// [1, 6]}. All conditions of a match must hold; `match: any` always holds. A rule without a class sets only the
// material, and the search for a class goes on; a rule without a material sets only the class. `drop: true` in place of
// a class leaves the triangles out.
struct Rule {
  Location where;
  std::string node, material, texture, file;  // patterns; empty: anything
  std::vector<Rgb> colors;                    // base colours in the triangle's middle that match; empty: any
  int within = 16;                            // largest difference of red, green and blue from one of `colors`
  std::optional<Box> box;                     // must contain the triangle's middle, in the asset's frame, m
  std::optional<Between> height;              // height of the triangle's middle above the asset's lowest point, m
  std::optional<Between> slope;               // slope of the triangle: its angle to the horizontal, rad
  std::optional<Between> size;                // the longest edge of the box about the connected part, m
  std::string className, materialName;        // empty: not set by this rule
  bool drop = false;

  // True if the rule tests single triangles, not names alone.
  bool byTriangle() const { return !colors.empty() || box || height || slope || size; }
  bool decides() const { return drop || !className.empty(); }
};

// Reads a list of rules. Throws InputError with the place.
std::vector<Rule> readRules(const Value& value);

// Describes a rule's conditions, such as "node: Wall*, height: 0 to 2.5".
std::string describe(const Rule& rule);

// Returns the file name at the end of a texture's path, in which slashes or backslashes separate the folders.
std::string_view textureName(std::string_view path);

// The names of a part that patterns are compared with; empty if the part has no such name.
struct Names {
  std::string_view node, material, texture, file;
};
bool matchesNames(const Rule& rule, const Names& names);

struct TriangleTraits {
  Rgb color{};
  Vec3d middle;       // in the asset's frame, m
  double height = 0;  // above the asset's lowest point, m
  double slope = 0;   // from horizontal, rad
  double size = 0;    // size of the connected part, m
};
bool matchesTriangle(const Rule& rule, const TriangleTraits& traits);

// True if a text matches a pattern, a glob or a /regular expression/. Throws InputError at `where` for an invalid
// regular expression.
bool matches(const std::string& pattern, std::string_view text, const Location& where);

// Returns the part of a text that a /regular expression/ matches: its first group, or the whole match if it has no
// group; nothing if it matches nothing. Throws as matches() does.
std::optional<std::string> matchedText(const std::string& pattern, std::string_view text, const Location& where);

}  // namespace scanmill
