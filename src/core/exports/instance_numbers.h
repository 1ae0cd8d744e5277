#pragma once

// Numbers the instances of each sequence anew, for layouts that cannot store the dataset's instance ids.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "exports/layout.h"

namespace scanmill {

// Numbering needs all frames of a sequence, so that the numbers do not depend on the order in which frames are
// processed: ExportLayout::checkSample() adds them. Safe to use from several threads.
class InstanceNumbers {
 public:
  // A group and an instance id of the dataset. Each group is numbered from 1, in the order of the ids.
  using Instance = std::pair<std::uint16_t, std::uint32_t>;
  // Returns the instances that a scan of a sample has.
  using InstancesOf = std::function<std::set<Instance>(const ExportPlan& plan, const Scan& scan)>;

  // `most`: the largest number. `groupName`: what a group is called in messages, such as "instances of car".
  InstanceNumbers(std::string layout, std::size_t most, InstancesOf instancesOf,
                  std::function<std::string(const ExportPlan&, std::uint16_t)> groupName);

  // Throws InputError if a group of the sample's sequence has more than `most` instances.
  void add(const ExportPlan& plan, const ExportSample& sample);

  // Returns the numbers of a sequence's instances. All of its samples must have been added.
  std::map<Instance, std::uint16_t> numbersOf(std::size_t sequence);

 private:
  using IdsByGroup = std::map<std::uint16_t, std::set<std::uint32_t>>;  // the dataset's instance ids

  std::string layout_;
  std::size_t most_;
  InstancesOf instancesOf_;
  std::function<std::string(const ExportPlan&, std::uint16_t)> groupName_;
  std::mutex mutex_;
  std::map<std::size_t, IdsByGroup> idsOfSequence_;
};

}  // namespace scanmill
