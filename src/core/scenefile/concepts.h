#pragma once

// Reads labels/words.yaml: the classes and materials that words in names usually stand for.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scene/ontology.h"
#include "scenefile/rules.h"

namespace scanmill {

enum class ConceptKind { Ground, Whole, Detail, Drop };

struct Concept {
  std::string name;
  std::vector<std::string> classes;  // the first that the ontology has is taken
  std::string material;              // a name in labels/materials.yaml; empty: none
  ConceptKind kind = ConceptKind::Whole;
  std::vector<std::string> of;  // of a detail: the concepts that have it, and their classes too unless it has its own
  std::optional<Between> size;  // m, along the longest edge
  std::vector<std::string> words;  // folded: see foldedName()
};

// Reads such a file. Throws InputError with the place.
std::vector<Concept> readConcepts(const std::filesystem::path& path);

// Returns the class that a concept has in an ontology: the first of the concept's classes that the ontology has, by
// name or alias; null if it has none of them.
const SemanticClass* classOf(const Concept& what, const Ontology& ontology);

// Returns a name in lower case without accents, digits and signs, its words separated by blanks: "Haupt-Straße_01",
// "BusStop2" and "grass.001" become "haupt strasse", "bus stop" and "grass".
std::string foldedName(std::string_view name);

// Returns the concept of the word that ends last in a name, the longest word if several end there; null if there is
// none.
const Concept* conceptOf(const std::vector<Concept>& concepts, std::string_view name);

// Returns the concepts of the words of a name, in their order. Two words can be one entry ("street lamp").
std::vector<const Concept*> conceptsIn(const std::vector<Concept>& concepts, std::string_view name);

// Returns, by id of a thing class, the longest edge (m) of its smallest and of its largest things, over all concepts
// with that class. Classes without a concept are left out. So are classes that concepts fall back to if the ontology
// lacks their own class, as "object" is for chairs: such a class holds things of any size.
std::map<std::uint16_t, Between> usualSizes(const std::vector<Concept>& concepts, const Ontology& ontology);

// Returns the concepts of labels/words.yaml; an empty list if the file is missing, so that only the warnings that need
// it are lost.
std::vector<Concept> knownConcepts();

// Returns the ids of thing classes that have wheels: those of the concepts that have a detail with the word "wheel".
std::set<std::uint16_t> classesWithWheels(const std::vector<Concept>& concepts, const Ontology& ontology);

}  // namespace scanmill
