#pragma once

// An ontology: the classes of a dataset, as files such as labels/scanmill.yaml state them.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace scanmill {

struct SemanticClass {
  std::uint16_t id = 0;
  std::string name;
  std::array<std::uint8_t, 3> color{};      // RGB
  bool thing = false;                       // countable: its objects get instance ids
  std::vector<std::string> aliases;         // names that scenes may use for this class
  std::optional<std::uint16_t> movingOf{};  // the class of things that this is for while they move
};

// Class 0 is always "unlabeled".
struct Ontology {
  std::string name;
  std::string source;  // where the ids come from
  std::vector<SemanticClass> classes;

  // The class with this id; null where there is none.
  const SemanticClass* find(std::uint16_t id) const;
  // The class with this name or, where there is none, with this alias; null where there is neither.
  const SemanticClass* find(std::string_view nameOrAlias) const;
  // The same; throws an InputError at `where`, with a suggestion, where there is none.
  const SemanticClass& require(std::string_view nameOrAlias, const Location& where) const;
};

// Returns true if both have the same ids, names and things, whatever their colours and aliases.
bool sameClasses(const Ontology& a, const Ontology& b);

// What becomes of the classes of one ontology where another takes its place, one line each: those that become one, and
// those that have no class there, which a scene that uses them would be refused for. Empty where nothing is lost.
std::vector<std::string> lostBetween(const Ontology& from, const Ontology& to);

// Reads an ontology's file. Ids and names must be unique, ids at most 65535, and colours [r, g, b] of 0 to 255. Throws
// InputError with the place.
Ontology readOntology(const std::filesystem::path& path);

}  // namespace scanmill
