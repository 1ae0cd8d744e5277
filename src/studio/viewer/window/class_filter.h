#pragma once

// Which classes are shown.

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "scene/ontology.h"

namespace scanmill {

// By class id, so that it holds whatever the colours stand for.
class ClassFilter {
 public:
  ClassFilter() = default;
  // Classes by name, alias or id that are hidden or, with `only`, alone shown. Throws InputError for one that the
  // ontology does not know; without an ontology there are only ids.
  ClassFilter(const std::vector<std::string>& names, bool only, const Ontology* ontology);

  bool shows(std::uint16_t id) const { return listed_.contains(id) == only_; }
  bool showsAll() const { return !only_ && listed_.empty(); }
  void toggle(std::uint16_t id);
  // This class alone.
  void showOnly(std::uint16_t id);
  void showAll();
  // "without road, car", "only road"; empty where all are shown.
  std::string text(const Ontology* ontology) const;

 private:
  bool only_ = false;  // what `listed_` means: those shown, or those hidden
  std::set<std::uint16_t> listed_;
};

}  // namespace scanmill
