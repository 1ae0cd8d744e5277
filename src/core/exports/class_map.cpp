#include "exports/class_map.h"

#include <algorithm>
#include <utility>

namespace scanmill {

namespace {

// Returns the class of `to` with the name of `own` or, if there is none, with one of the aliases of `own`; null if `to`
// has none of these names.
const SemanticClass* counterpart(const SemanticClass& from, const Ontology& to) {
  if (const SemanticClass* found = to.find(std::string_view(from.name))) return found;
  for (const std::string& alias : from.aliases) {
    if (const SemanticClass* found = to.find(std::string_view(alias))) return found;
  }
  return nullptr;
}

}  // namespace

ClassMap::ClassMap(const Ontology& from, Ontology to) : target_(std::move(to)) {
  std::uint16_t last = 0;
  for (const SemanticClass& c : from.classes) last = std::max(last, c.id);
  of_.assign(std::size_t{last} + 1, 0);
  for (const SemanticClass& c : from.classes) {
    const SemanticClass* found = counterpart(c, target_);
    if (found == nullptr && c.movingOf) {
      const SemanticClass* const still = from.find(*c.movingOf);
      if (still != nullptr) found = counterpart(*still, target_);
    }
    if (found != nullptr) of_[c.id] = found->id;
  }
}

std::uint16_t ClassMap::ofMoving(std::uint16_t id) const {
  const std::uint16_t target = of(id);
  for (const SemanticClass& c : target_.classes) {
    if (c.movingOf == target && target != 0) return c.id;
  }
  return target;
}

}  // namespace scanmill
