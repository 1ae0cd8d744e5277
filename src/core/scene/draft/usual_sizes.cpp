#include "scene/draft/usual_sizes.h"

#include <algorithm>
#include <set>

namespace scanmill::draft {

std::map<std::uint16_t, Between> usualSizes(const std::vector<Concept>& concepts, const Ontology& ontology) {
  std::map<std::uint16_t, Between> sizes;
  std::set<std::uint16_t> rest;
  for (const Concept& c : concepts) {
    const SemanticClass* const known = classOf(c, ontology);
    if (c.kind != ConceptKind::Whole || !c.size || known == nullptr || !known->thing) continue;
    if (ontology.find(c.classes.front()) != known) rest.insert(known->id);
    const auto [own, added] = sizes.emplace(known->id, *c.size);
    if (added) continue;
    own->second.low = std::min(own->second.low, c.size->low);
    own->second.high = std::max(own->second.high, c.size->high);
  }
  std::erase_if(sizes, [&](const auto& size) { return rest.contains(size.first); });
  return sizes;
}

}  // namespace scanmill::draft
