#pragma once

// Which class and material a part of an asset gets: rules of a scene file, first match wins.

#include <string>
#include <string_view>
#include <vector>

#include "config/value.h"

namespace scanmill {

// YAML: {match: {node: "House*Mesh", material: roof, texture: "*leaf*", file: "/car_[0-9]+/"}, class: building,
// material: roof_tile}. A pattern is a glob (*, ?, [a-z]; the whole name, case-sensitive) or, between slashes, an
// ECMAScript regular expression (searched). All patterns of a match must hold; `match: any` holds always. class and
// material may be left out: a rule without a class sets only the material, and the search for a class goes on (and the
// other way round).
struct Rule {
  Location where;
  std::string node, material, texture, file;  // patterns; empty: anything
  std::string className, materialName;        // empty: not set by this rule
};

std::vector<Rule> readRules(const Value& value);

struct Names {
  std::string_view node, material, texture, file;
};

// The first rule with a class that matches, the first with a material that matches; null where none.
struct Verdict {
  const Rule* className = nullptr;
  const Rule* material = nullptr;
};
Verdict matchRules(const std::vector<Rule>& rules, const Names& names);

// Whether `text` fits a pattern (glob or /regex/). Throws InputError at `where` for a bad regular expression.
bool matches(const std::string& pattern, std::string_view text, const Location& where);

}  // namespace scanmill
