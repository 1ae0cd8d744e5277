#include "exports/instance_numbers.h"

#include <fmt/core.h>

#include "base/error.h"

namespace scanmill {

InstanceNumbers::InstanceNumbers(std::string layout, std::size_t most, InstancesOf instancesOf,
                                 std::function<std::string(const ExportPlan&, std::uint16_t)> groupName)
    : layout_(std::move(layout)), most_(most), instancesOf_(std::move(instancesOf)), groupName_(std::move(groupName)) {}

void InstanceNumbers::add(const ExportPlan& plan, const ExportSample& sample) {
  std::set<Instance> instances;
  for (const ExportScan& scan : sample.scans) instances.merge(instancesOf_(plan, scan.scan));
  const std::scoped_lock lock(mutex_);
  for (const auto& [group, id] : instances) {
    std::set<std::uint32_t>& ids = idsOfSequence_[sample.sequence][group];
    ids.insert(id);
    if (ids.size() <= most_) continue;
    throw InputError(
        {plan.dataset.string()},
        fmt::format("the sample {} belongs to a sequence with more than {} {}, the most that {} can number: generate "
                    "shorter sequences or fewer objects, or leave the column instance out",
                    sample.record->key, most_, groupName_(plan, group), layout_));
  }
}

std::map<InstanceNumbers::Instance, std::uint16_t> InstanceNumbers::numbersOf(std::size_t sequence) {
  const std::scoped_lock lock(mutex_);
  std::map<Instance, std::uint16_t> numbers;
  for (const auto& [group, ids] : idsOfSequence_[sequence]) {
    std::uint16_t number = 0;
    for (const std::uint32_t id : ids) numbers[{group, id}] = ++number;
  }
  return numbers;
}

}  // namespace scanmill
