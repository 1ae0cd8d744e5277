#pragma once

// Reads a key whose value is one of the names in a table.

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/fields.h"

namespace scanmill {

// Returns the entry of `values` that the key names; the entry of `fallback` if the key is absent.
template <class T, std::size_t n>
const std::pair<const char*, T>& namedChoice(Fields& fields, std::string_view key,
                                             const std::pair<const char*, T> (&values)[n], T fallback) {
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.emplace_back(name);
  const auto usual =
      std::find_if(std::begin(values), std::end(values), [&](const auto& v) { return v.second == fallback; });
  const std::string chosen = fields.choice(key, names, usual->first);
  return *std::find_if(std::begin(values), std::end(values), [&](const auto& v) { return chosen == v.first; });
}

}  // namespace scanmill
