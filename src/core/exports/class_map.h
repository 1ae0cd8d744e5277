#pragma once

// Maps the classes of one ontology to the classes of another.

#include <cstdint>
#include <vector>

#include "scene/ontology.h"

namespace scanmill {

class ClassMap {
 public:
  ClassMap() = default;
  // Maps a class of `from` to its counterpart: the class of `to` with the same name, or with one of its aliases as
  // name. A class for moving objects without a counterpart is mapped as the class for objects of its kind that stand
  // still. All other classes without a counterpart are mapped to 0 (unlabeled).
  ClassMap(const Ontology& from, Ontology to);

  const Ontology& target() const { return target_; }
  // Returns the id of the target's class for the class `id` of `from`; 0 if this class has no counterpart.
  std::uint16_t targetId(std::uint16_t id) const { return id < targetIds_.size() ? targetIds_[id] : 0; }
  const SemanticClass& classOf(std::uint16_t id) const { return *target_.find(targetId(id)); }
  // Returns the id of the target's class for an object of the class `id` that moves: the class for moving objects of
  // its kind, if the target has one, otherwise targetId(id).
  std::uint16_t movingTargetId(std::uint16_t id) const;

 private:
  Ontology target_;
  std::vector<std::uint16_t> targetIds_;  // by class id of `from`
};

}  // namespace scanmill
