#pragma once

// Items of YAML that are names: with options, such as a method, an effect or a format, or of a table.

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/fields.h"

namespace scanmill {

struct NamedOptions {
  std::string name;
  Location where;
  Value options;  // a value of the kind Null if only a name is given
};

// Reads "name" or {name: {options}}. `what` describes the item in messages, such as "an effect". Throws InputError.
NamedOptions readNamed(const Value& value, const std::string& what);

// Returns the entry of `values` that the key names; the entry of `fallback`, which `values` must have, if the key is
// absent.
template <class T, std::size_t n>
const std::pair<const char*, T>& namedChoice(Fields& fields, std::string_view key,
                                             const std::pair<const char*, T> (&values)[n], T fallback) {
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.emplace_back(name);
  const std::string chosen = fields.choice(key, names, "");
  return *std::find_if(std::begin(values), std::end(values), [&](const auto& entry) {
    return chosen.empty() ? entry.second == fallback : chosen == entry.first;
  });
}

}  // namespace scanmill
