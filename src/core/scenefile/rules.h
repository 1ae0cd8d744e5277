#pragma once

// The rules of a scene file, which say which class and material a part of an asset gets. The first that matches wins.

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
// building, material: roof_tile}. A pattern is a glob (*, ?, [a-z], {one,another}), which must match the whole name,
// upper and lower case being different; or, between slashes, an ECMAScript regular expression, which must match some
// part of the name. A glob of `texture` without a slash is compared with the name of the file alone, not its folders.
// Other keys tell the triangles of one part from each other: {color: "#8fb34d", within: 16, box: [[0, 0, 0], [9, 9,
// 3]], height: [0, 2.5], slope_deg: [0, 30], size: [1, 6]}. All that a match says must hold; `match: any` holds always.
// A rule may lack a class or a material. One without a class sets only the material, and the search for a class goes
// on; one without a material likewise. `drop: true` in place of a class leaves the triangles out.
struct Rule {
  Location where;
  std::string node, material, texture, file;  // patterns; empty: anything
  std::vector<Rgb> colors;                    // of the base colour in the triangle's middle; empty: any
  int within = 16;                            // how much red, green and blue may differ from one of them
  std::optional<Box> box;                     // where the triangle's middle is, in the asset's frame, m
  std::optional<Between> height;              // of the triangle's middle above the asset's lowest point, m
  std::optional<Between> slope;               // of the triangle, from level, rad
  std::optional<Between> size;                // the longest edge of the box about the connected part, m
  std::string className, materialName;        // empty: not set by this rule
  bool drop = false;

  // Whether it tells triangles of one part from each other.
  bool byTriangle() const { return !colors.empty() || box || height || slope || size; }
  bool decides() const { return drop || !className.empty(); }
};

// Reads a list of rules. Throws InputError with the place.
std::vector<Rule> readRules(const Value& value);

// In words, such as {node: Wall*, height: 0 to 2.5}.
std::string describe(const Rule& rule);

// The name of a texture's file without its folders, whether slashes or backslashes divide them.
std::string_view textureName(std::string_view path);

// What the patterns are compared with; empty where a part has no such name.
struct Names {
  std::string_view node, material, texture, file;
};
bool matchesNames(const Rule& rule, const Names& names);

struct TriangleTraits {
  Rgb color{};
  Vec3d middle;       // in the asset's frame, m
  double height = 0;  // above the asset's lowest point, m
  double slope = 0;   // from level, rad
  double size = 0;    // of the connected part, m
};
bool matchesTriangle(const Rule& rule, const TriangleTraits& traits);

// Whether a text matches a pattern, a glob or a /regular expression/. Throws an InputError at `where` for a regular
// expression that is none.
bool matches(const std::string& pattern, std::string_view text, const Location& where);

// What a /regular expression/ matches in a text: its first group, or all of the match where it has none; absent where
// it matches nothing. Throws as matches() does.
std::optional<std::string> matchedText(const std::string& pattern, std::string_view text, const Location& where);

}  // namespace scanmill
