#pragma once

// What things usually are like, by labels/words.yaml.

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "scene/draft/words.h"
#include "scene/ontology.h"

namespace scanmill::draft {

// Of classes of things, by their ids: the longest edge (m) of the smallest and the largest that words of it name.
// Classes that no word leads to are left out, and those that words fall back to where the ontology lacks their own, as
// "object" is for chairs: these hold things of any size.
std::map<std::uint16_t, Between> usualSizes(const std::vector<Concept>& concepts, const Ontology& ontology);

// The concepts of labels/words.yaml; none where the file is missing, since a warning less is better than none of the
// rest.
std::vector<Concept> knownConcepts();

// The ids of the classes of things that have wheels: of the concepts of which a detail has the word "wheel".
std::set<std::uint16_t> classesWithWheels(const std::vector<Concept>& concepts, const Ontology& ontology);

}  // namespace scanmill::draft
