#pragma once

// Reads labels/words.yaml: the classes and materials that words in names usually stand for.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/ontology.h"
#include "scenefile/rules.h"

namespace scanmill {

// States what a concept names: ground, a complete object, a part of objects, or geometry to drop, such as collision
// shapes.
enum class ConceptKind { Ground, Whole, Detail, Drop };

struct Concept {
  std::string name;
  std::vector<std::string> classes;  // in order of preference: the first that the ontology has is used
  std::string material;              // a name in labels/materials.yaml; empty: none
  ConceptKind kind = ConceptKind::Whole;
  // Only for a detail: names of the concepts that have it. A detail without classes gets the classes of these concepts.
  std::vector<std::string> wholes;
  std::optional<Range> size;       // m, usual lengths of the longest edge of a thing's bounding box
  std::vector<std::string> words;  // words that state this concept in names, as foldedName() returns them
};

// Reads a file such as labels/words.yaml. Throws InputError with the place of the fault in the file.
std::vector<Concept> readConcepts(const std::filesystem::path& path);

// Returns the first of a concept's classes that the ontology has, by name or alias; null if the ontology has none.
const SemanticClass* classOf(const Concept& nameConcept, const Ontology& ontology);

// Returns a name in lower case, without accents, digits and signs, with blanks between its words: "Haupt-Straße_01",
// "BusStop2" and "grass.001" become "haupt strasse", "bus stop" and "grass".
[[nodiscard]] std::string foldedName(std::string_view name);

// Returns the concept whose word ends last in a name; of several words with the same end, the longest word decides.
// Null if the name contains no word of a concept.
const Concept* conceptOf(const std::vector<Concept>& concepts, std::string_view name);

// Returns the concepts of a name's words, in the order of the words; words without a concept are skipped. Two
// successive words that one concept lists as a pair ("street lamp") give this concept only.
std::vector<const Concept*> conceptsIn(const std::vector<Concept>& concepts, std::string_view name);

// Returns the class with this name or alias. Throws InputError at `where` if there is none; if the name is a word of
// labels/words.yaml, such as "lorry", the message names the class of its concept.
const SemanticClass& requireClass(const Ontology& ontology, const std::string& name, const Location& where);

}  // namespace scanmill
