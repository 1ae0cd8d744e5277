#pragma once

// The classes of a dataset: labels/*.yaml.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace scanmill {

struct SemanticClass {
  std::uint16_t id = 0;
  std::string name;
  std::array<std::uint8_t, 3> color{};  // RGB
  bool thing = false;                   // countable: its objects get instance ids
  std::vector<std::string> aliases;     // names that scenes may use for this class
};

// Class 0 is always "unlabeled".
struct Ontology {
  std::string name;
  std::string source;  // where the ids come from
  std::vector<SemanticClass> classes;

  // By id; null where absent.
  const SemanticClass* find(std::uint16_t id) const;
  // By name, then by alias. Throws InputError at `where` with a suggestion.
  const SemanticClass& require(std::string_view nameOrAlias, const Location& where) const;
};

// Throws InputError with the place: ids and names must be unique, ids at most 65535, colours [r, g, b] of 0 to 255.
Ontology readOntology(const std::filesystem::path& path);

}  // namespace scanmill
