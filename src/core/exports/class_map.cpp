#include "exports/class_map.h"

#include <algorithm>
#include <utility>

namespace scanmill {

namespace {

// Returns the class of the ontology with the name of `semantic` or, if there is none, with one of its aliases; null if
// the ontology has none of these names.
const SemanticClass* counterpart(const SemanticClass& semantic, const Ontology& ontology) {
  const SemanticClass* match = ontology.find(std::string_view(semantic.name));
  for (std::size_t i = 0; match == nullptr && i < semantic.aliases.size(); ++i) {
    match = ontology.find(std::string_view(semantic.aliases[i]));
  }
  return match;
}

}  // namespace

ClassMap::ClassMap(const Ontology& from, Ontology to) : target_(std::move(to)) {
  std::uint16_t largestId = 0;
  for (const SemanticClass& c : from.classes) largestId = std::max(largestId, c.id);
  targetIds_.assign(std::size_t{largestId} + 1, 0);
  for (const SemanticClass& c : from.classes) {
    const SemanticClass* match = counterpart(c, target_);
    const SemanticClass* const still = match == nullptr && c.movingOf ? from.find(*c.movingOf) : nullptr;
    if (still != nullptr) match = counterpart(*still, target_);
    if (match != nullptr) targetIds_[c.id] = match->id;
  }
}

std::uint16_t ClassMap::movingTargetId(std::uint16_t id) const {
  const std::uint16_t stillId = targetId(id);
  const auto moving = std::ranges::find(target_.classes, stillId, &SemanticClass::movingOf);
  return stillId == 0 || moving == target_.classes.end() ? stillId : moving->id;
}

}  // namespace scanmill
