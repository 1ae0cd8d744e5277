#pragma once

// Maps the classes of one ontology to those of another.

#include <cstdint>
#include <string>
#include <vector>

#include "scene/ontology.h"

namespace scanmill {

class ClassMap {
 public:
  ClassMap() = default;
  // Maps a class of `from` to the class of `to` that has its name or one of its aliases. A class for moving objects
  // without such a counterpart becomes that of still ones. Other classes without a counterpart become 0 (unlabeled).
  ClassMap(const Ontology& from, Ontology to);

  const Ontology& target() const { return target_; }
  // Returns the target's class for a class of the first ontology; 0 if that has no such class.
  std::uint16_t of(std::uint16_t id) const { return id < of_.size() ? of_[id] : 0; }
  const SemanticClass& classOf(std::uint16_t id) const { return *target_.find(of(id)); }
  // Does the same for an object that moves: returns the target's class for moving objects of its kind, if it has one.
  std::uint16_t ofMoving(std::uint16_t id) const;
  // Returns one line for each class that becomes unlabeled.
  const std::vector<std::string>& lost() const { return lost_; }

 private:
  Ontology target_;
  std::vector<std::uint16_t> of_;  // by id
  std::vector<std::string> lost_;
};

}  // namespace scanmill
