#pragma once

// Decides which classes are shown.

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "scene/ontology.h"

namespace scanmill {

// A filter by class id. It is independent of the quantity that colours show.
class ClassFilter {
 public:
  ClassFilter() = default;
  // `names`: names, aliases or ids of classes. These classes are hidden; if `only` is true, all other classes are
  // hidden instead. Throws InputError for a name that the ontology lacks; without an ontology only ids are accepted.
  ClassFilter(const std::vector<std::string>& names, bool only, const Ontology* ontology);

  bool shows(std::uint16_t id) const { return listed_.contains(id) == only_; }
  bool showsAll() const { return !only_ && listed_.empty(); }
  void toggle(std::uint16_t id);
  // Shows this class alone.
  void showOnly(std::uint16_t id);
  void showAll();
  // Returns a description, such as "without road, car" or "only road"; empty if all classes are shown.
  std::string text(const Ontology* ontology) const;

 private:
  bool only_ = false;  // `listed_` are the classes shown (true) or the classes hidden (false)
  std::set<std::uint16_t> listed_;
};

}  // namespace scanmill
