#pragma once

// What words in names usually mean: labels/words.yaml.

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
  std::vector<std::string> classes;  // the first that an ontology has is meant
  std::string material;              // of the program's table; empty: none
  ConceptKind kind = ConceptKind::Whole;
  std::vector<std::string> of;     // of a detail: the names of the concepts that have it, and whose class it has unless
                                   // it has its own
  std::optional<Between> size;     // m, along the longest edge
  std::vector<std::string> words;  // folded: see foldedName()
};

// Throws InputError with the place.
std::vector<Concept> readConcepts(const std::filesystem::path& path);

// The class of the ontology that it means: the first of its own that the ontology has, by name or alias; null where it
// has none.
const SemanticClass* classOf(const Concept& what, const Ontology& ontology);

// Lower case without accents, its parts with a blank between them: "Haupt-Straße_01", "BusStop2" and "grass.001" become
// "haupt strasse", "bus stop" and "grass".
std::string foldedName(std::string_view name);

// What a name means by the word that stands last in it, the longest of those that end there; null where it has none.
const Concept* conceptOf(const std::vector<Concept>& concepts, std::string_view name);

// What the words of a name mean, each by itself or two together ("street lamp"), in their order.
std::vector<const Concept*> conceptsIn(const std::vector<Concept>& concepts, std::string_view name);

// Of classes of things, by their ids: the longest edge (m) of the smallest and the largest that words of it name.
// Classes that no word leads to are left out, and those that words fall back to where the ontology lacks their own, as
// "object" is for chairs: these hold things of any size.
std::map<std::uint16_t, Between> usualSizes(const std::vector<Concept>& concepts, const Ontology& ontology);

// The concepts of labels/words.yaml; none where the file is missing, since a warning less is better than none of the
// rest.
std::vector<Concept> knownConcepts();

// The ids of the classes of things that have wheels: of the concepts of which a detail has the word "wheel".
std::set<std::uint16_t> classesWithWheels(const std::vector<Concept>& concepts, const Ontology& ontology);

}  // namespace scanmill
