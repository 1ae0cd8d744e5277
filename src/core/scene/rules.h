#pragma once

// The rules of a scene file, which say which class and material a part of an asset gets. The first that matches wins.

#include <string>
#include <string_view>
#include <vector>

#include "config/value.h"

namespace scanmill {

// In YAML: {match: {node: "House*Mesh", material: roof, texture: "*leaf*", file: "/car_[0-9]+/"}, class: building,
// material: roof_tile}. A pattern is a glob (*, ?, [a-z]), which must match the whole name, upper and lower case being
// different; or, between slashes, an ECMAScript regular expression, which must match some part of the name. All
// patterns of a match must hold; `match: any` holds always. A rule may lack a class or a material. One without a class
// sets only the material, and the search for a class goes on; one without a material likewise.
struct Rule {
  Location where;
  std::string node, material, texture, file;  // patterns; empty: anything
  std::string className, materialName;        // empty: not set by this rule
};

// Reads a list of rules. Throws InputError with the place.
std::vector<Rule> readRules(const Value& value);

// What the patterns are compared with; empty where a part has no such name.
struct Names {
  std::string_view node, material, texture, file;
};

// The first matching rule with a class, and the first matching rule with a material; null where there is none.
struct Verdict {
  const Rule* className = nullptr;
  const Rule* material = nullptr;
};
Verdict matchRules(const std::vector<Rule>& rules, const Names& names);

// Whether a text matches a pattern, a glob or a /regular expression/. Throws an InputError at `where` for a regular
// expression that is none.
bool matches(const std::string& pattern, std::string_view text, const Location& where);

}  // namespace scanmill
