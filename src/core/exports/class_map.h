#pragma once

// Which classes of an ontology become which of another.

#include <cstdint>
#include <string>
#include <vector>

#include "scene/ontology.h"

namespace scanmill {

class ClassMap {
 public:
  ClassMap() = default;
  // By names and aliases of `to`; a class for what moves becomes that of what stands where `to` has none. Classes that
  // have none there become 0 (unlabeled).
  ClassMap(const Ontology& from, Ontology to);

  const Ontology& target() const { return target_; }
  // The target's class of one of the first ontology; 0 for what that does not know.
  std::uint16_t of(std::uint16_t id) const { return id < of_.size() ? of_[id] : 0; }
  const SemanticClass& classOf(std::uint16_t id) const { return *target_.find(of(id)); }
  // The same of a thing that moves: the target's class for that, if it has one.
  std::uint16_t ofMoving(std::uint16_t id) const;
  // One line each: classes that become unlabeled.
  const std::vector<std::string>& lost() const { return lost_; }

 private:
  Ontology target_;
  std::vector<std::uint16_t> of_;  // by id
  std::vector<std::string> lost_;
};

}  // namespace scanmill
