#pragma once

// Maps the classes of one ontology to the classes of another.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/ontology.h"

namespace scanmill {

class ClassMap {
 public:
  ClassMap() = default;
  // Maps each class of `from` to the class of `to` that has the same name or, if there is none, one of its aliases as
  // name. If `to` has neither, a class for moving objects is mapped like the class for the same objects at rest, and
  // any other class is mapped to 0 (unlabeled).
  ClassMap(const Ontology& from, Ontology to) : target_(std::move(to)) {
    std::uint16_t largestId = 0;
    for (const SemanticClass& c : from.classes) largestId = std::max(largestId, c.id);
    targetIds_.assign(std::size_t{largestId} + 1, 0);
    for (const SemanticClass& c : from.classes) {
      const SemanticClass* match = counterpart(c);
      const SemanticClass* const still = match == nullptr && c.movingOf ? from.find(*c.movingOf) : nullptr;
      if (still != nullptr) match = counterpart(*still);
      if (match != nullptr) targetIds_[c.id] = match->id;
    }
  }

  const Ontology& target() const { return target_; }
  // Returns the id of the target's class for the class `id` of `from`; 0 if this class has no counterpart.
  std::uint16_t targetId(std::uint16_t id) const { return id < targetIds_.size() ? targetIds_[id] : 0; }
  const SemanticClass& classOf(std::uint16_t id) const { return *target_.find(targetId(id)); }
  // Returns the id of the target's class for an object of the class `id` that moves: the class for moving objects of
  // its kind, if the target has one, otherwise targetId(id).
  std::uint16_t movingTargetId(std::uint16_t id) const {
    const std::uint16_t stillId = targetId(id);
    const auto moving = std::ranges::find(target_.classes, stillId, &SemanticClass::movingOf);
    return stillId == 0 || moving == target_.classes.end() ? stillId : moving->id;
  }

 private:
  // Returns the target's class whose name is the name or, if there is none, an alias of `semantic`; null if the target
  // has none of these names.
  const SemanticClass* counterpart(const SemanticClass& semantic) const {
    const SemanticClass* match = target_.find(std::string_view(semantic.name));
    for (std::size_t i = 0; match == nullptr && i < semantic.aliases.size(); ++i) {
      match = target_.find(std::string_view(semantic.aliases[i]));
    }
    return match;
  }

  Ontology target_;
  std::vector<std::uint16_t> targetIds_;  // ids of the target's classes, by class id of `from`
};

}  // namespace scanmill
