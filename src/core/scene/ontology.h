#pragma once

// An ontology: the classes of a dataset, as files such as labels/scanmill.yaml define them. This header
// is installed because scene/scene.h includes it.
//
//   const Ontology ontology = readOntology("labels/scanmill.yaml");
//   const std::uint16_t road = ontology.require("road", {}).id;

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
  bool thing = false;                       // true: its objects can be counted and get instance ids
  std::vector<std::string> aliases;         // names that scenes may use for this class
  std::optional<std::uint16_t> movingOf{};  // for a class of moving objects: the class of the same objects at rest
  bool roadUser = false;                    // true: a person, an animal or a vehicle, whose boxes detectors learn
};

// The classes of a dataset. Class 0 is always "unlabeled".
struct Ontology {
  std::string name;
  std::string source;  // where the ids come from
  std::vector<SemanticClass> classes = {};

  // Returns the class with this id, or null.
  const SemanticClass* find(std::uint16_t id) const;
  // Returns the class with this name, else the class with this alias, else null.
  const SemanticClass* find(std::string_view nameOrAlias) const;
  // Returns the class as find() does. If there is none, throws an InputError at `where`, with a suggestion.
  const SemanticClass& require(std::string_view nameOrAlias, const Location& where) const;
};

// Returns true if the ontologies have the same ids, names and `thing` flags in the same order. Other fields may differ.
bool sameClasses(const Ontology& a, const Ontology& b);

// Describes what is lost if `newOntology` replaces `oldOntology`: one line for each new class into which several old
// classes merge, and one line that lists all old classes without a new class (a scene that uses such a class is
// refused). The result is empty if nothing is lost.
std::vector<std::string> lostBetween(const Ontology& oldOntology, const Ontology& newOntology);

// Reads an ontology's file. Ids, names and aliases must be unique, ids at most 65535, and colours [r, g, b] from 0 to
// 255. Throws InputError with the place in the file.
Ontology readOntology(const std::filesystem::path& path);

// Returns the ids of the classes with these names or aliases. Throws InputError at `where` for an unknown name.
std::vector<std::uint16_t> classIds(const Ontology& ontology, const std::vector<std::string>& names,
                                    const Location& where);

}  // namespace scanmill
