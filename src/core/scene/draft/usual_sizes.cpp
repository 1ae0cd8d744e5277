#include "scene/draft/usual_sizes.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>

#include "config/resources.h"

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

std::vector<Concept> knownConcepts() {
  const std::filesystem::path file = resourceFolder() / "labels/words.yaml";
  std::error_code ignored;
  return std::filesystem::exists(file, ignored) ? readConcepts(file) : std::vector<Concept>{};
}

std::set<std::uint16_t> classesWithWheels(const std::vector<Concept>& concepts, const Ontology& ontology) {
  std::set<std::string> names;
  for (const Concept& c : concepts) {
    const bool isWheel = std::find(c.words.begin(), c.words.end(), "wheel") != c.words.end();
    if (isWheel && c.kind == ConceptKind::Detail) names.insert(c.of.begin(), c.of.end());
  }
  std::set<std::uint16_t> ids;
  for (const Concept& c : concepts) {
    const SemanticClass* const known = classOf(c, ontology);
    // One that stands in where the ontology lacks the concept's own holds other things as well.
    const bool isOwn = known != nullptr && ontology.find(c.classes.front()) == known;
    if (names.contains(c.name) && isOwn && known->thing) ids.insert(known->id);
  }
  return ids;
}

}  // namespace scanmill::draft
