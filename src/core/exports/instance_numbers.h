#pragma once

// Numbers the instances of each sequence anew, for layouts that cannot store the dataset's instance ids.

#include <fmt/core.h>

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "base/error.h"
#include "exports/layout.h"

namespace scanmill {

// All frames of a sequence must be added (by ExportLayout::checkSample()) before instances get their numbers, which
// therefore do not depend on the order of the frames. Safe to use from several threads.
class InstanceNumbers {
 public:
  // An instance. All instances of a group get the numbers 1, 2, ... in the order of their ids.
  struct Instance {
    std::uint16_t group = 0;
    std::uint32_t id = 0;  // instance id of the dataset
    auto operator<=>(const Instance&) const = default;
  };
  using Numbers = std::map<Instance, std::uint16_t>;
  // A function that returns the instance of a point (an index into the scan); its id is 0 if there is none.
  using InstanceOf = Instance (*)(const ExportPlan& plan, const Scan& scan, std::size_t point);

  // `most`: the largest number. `groupName`: what a group is called in messages, such as "instances of car".
  InstanceNumbers(std::string layout, std::size_t most, InstanceOf instanceOf,
                  std::function<std::string(const ExportPlan&, std::uint16_t)> groupName)
      : layout_(std::move(layout)), most_(most), instanceOf_(instanceOf), groupName_(std::move(groupName)) {}

  // Adds the instances of a sample. Throws InputError if a group of its sequence then has more than `most` instances.
  void add(const ExportPlan& plan, const ExportSample& sample) {
    std::set<Instance> instances;
    for (const ExportScan& scan : sample.scans) {
      for (std::size_t i = 0; i < scan.scan.size(); ++i) instances.insert(instanceOf_(plan, scan.scan, i));
    }
    const std::scoped_lock lock(mutex_);
    for (const auto& [group, id] : instances) {
      if (id == 0) continue;
      std::set<std::uint32_t>& ids = idsOfSequence_[sample.sequence][group];
      ids.insert(id);
      if (ids.size() <= most_) continue;
      refuse(plan,
             "the sample {} belongs to a sequence with more than {} {}, the most that {} can number: generate "
             "shorter sequences or fewer objects, or leave the column instance out",
             sample.record->key, most_, groupName_(plan, group), layout_);
    }
  }

  // Returns the numbers of a sequence's instances. All samples of the sequence must have been added.
  Numbers numbersOf(std::size_t sequence) {
    const std::scoped_lock lock(mutex_);
    Numbers numbers;
    for (const auto& [group, ids] : idsOfSequence_[sequence]) {
      std::uint16_t number = 0;
      for (const std::uint32_t id : ids) numbers[{group, id}] = ++number;
    }
    return numbers;
  }

 private:
  using IdsByGroup = std::map<std::uint16_t, std::set<std::uint32_t>>;  // the dataset's instance ids

  std::string layout_;
  std::size_t most_;
  InstanceOf instanceOf_;
  std::function<std::string(const ExportPlan&, std::uint16_t)> groupName_;
  std::mutex mutex_;
  std::map<std::size_t, IdsByGroup> idsOfSequence_;
};

}  // namespace scanmill
