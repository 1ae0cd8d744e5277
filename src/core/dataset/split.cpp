#include "dataset/split.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/hash.h"
#include "config/fields.h"

namespace scanmill {

namespace {

constexpr std::array<const char*, 3> kSplits = {"train", "val", "test"};
constexpr const char* kAdvice = "; --set splits=null puts all sequences into train";
using SplitOfGroup = std::map<std::string, std::string>;  // split by name of a group

// Returns the name of a sequence's group: its seed if `by` is "seed", its trajectory if `by` is "trajectory".
std::string groupOf(const SequenceName& sequence, const std::string& by) {
  return by == "seed" ? std::to_string(sequence.seed) : sequence.trajectory;
}

std::string plural(const std::string& by) {
  return by == "seed" ? "seeds" : "trajectories";
}

// Sorts groups by a hash of the seed and the group's name. The order of the groups in the pipeline therefore does not
// matter, and a new group does not change the order of the others.
std::vector<std::string> shuffled(const std::set<std::string>& groups, std::uint64_t seed) {
  std::vector<std::string> order(groups.begin(), groups.end());
  std::ranges::sort(order, {},
                    [&](const std::string& group) { return sha256(fmt::format("split {} {}", seed, group)); });
  return order;
}

// Returns the number of groups of each split: the integer part of its quota (its share of all groups), and one more for
// the splits with the largest remainders. Among equal remainders the first in kSplits is preferred.
std::array<std::size_t, kSplits.size()> apportion(const std::array<double, kSplits.size()>& shares,
                                                  std::size_t groups) {
  constexpr double kRounding = 1e-9;  // tolerance: 0.29 * 100 is just below 29
  std::array<std::size_t, kSplits.size()> counts{};
  std::array<double, kSplits.size()> remainders{};
  std::size_t assigned = 0;
  for (std::size_t i = 0; i < kSplits.size(); ++i) {
    const double quota = shares[i] * static_cast<double>(groups);
    counts[i] = static_cast<std::size_t>(std::floor(quota + kRounding));
    remainders[i] = quota - static_cast<double>(counts[i]);
    assigned += counts[i];
  }
  for (; assigned < groups; ++assigned) {
    std::size_t largest = 0;
    for (std::size_t i = 1; i < kSplits.size(); ++i) {
      if (remainders[i] > remainders[largest] + kRounding) largest = i;
    }
    ++counts[largest];
    remainders[largest] -= 1;
  }
  return counts;
}

// Assigns the groups to splits by shares such as {train: 0.8, val: 0.2}. Throws InputError if the shares do not sum to
// 1, or a share above 0 gets no group.
SplitOfGroup byShares(Fields& fields, const std::set<std::string>& groups, const std::string& by, std::uint64_t seed) {
  std::array<double, kSplits.size()> shares{};
  for (std::size_t i = 0; i < kSplits.size(); ++i) shares[i] = fields.number(kSplits[i], {0, 1}, 0);
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  if (std::abs(sum - 1) > 1e-6) throw InputError(fields.where(), "the sum of the shares is {}, but must be 1", sum);
  const auto counts = apportion(shares, groups.size());
  const std::vector<std::string> order = shuffled(groups, seed);
  SplitOfGroup splits;
  std::size_t assigned = 0;
  for (std::size_t i = 0; i < kSplits.size(); ++i) {
    if (shares[i] > 0 && counts[i] == 0) {
      throw InputError(
          fields.require(kSplits[i]).where,
          "{}: a share of {} of {} {} is less than one: add {}, change the shares, or list the {} of each split",
          kSplits[i], shares[i], groups.size(), groups.size() == 1 ? by : plural(by), plural(by), plural(by));
    }
    for (std::size_t n = 0; n < counts[i]; ++n) splits[order[assigned++]] = kSplits[i];
  }
  return splits;
}

// Returns the names of the groups in the list of a split, each with its place in the pipeline file.
std::vector<std::pair<std::string, Location>> listedGroups(const Value& list, const std::string& by) {
  std::vector<std::pair<std::string, Location>> groups;
  if (by == "seed") {
    for (const PlacedInteger& seed : readIntegers(list, "seed", 0, std::numeric_limits<std::int64_t>::max())) {
      groups.emplace_back(std::to_string(seed.value), seed.where);
    }
    return groups;
  }
  for (const Value& item : list.items) groups.emplace_back(readText(item, "trajectory"), item.where);
  return groups;
}

// Assigns groups by lists such as {train: [a, b], val: [c]}. Throws InputError unless each group is in exactly one
// list.
SplitOfGroup byLists(Fields& fields, const std::set<std::string>& groups, const std::string& by) {
  SplitOfGroup splits;
  for (const char* split : kSplits) {
    const Value* list = fields.find(split);
    if (list == nullptr) continue;
    for (const auto& [group, where] : listedGroups(*list, by)) {
      if (!groups.contains(group)) {
        throw InputError(where, "no sequence has the {} {} (known: {}){}", by, group, fmt::join(groups, ", "), kAdvice);
      }
      const auto [entry, isNew] = splits.emplace(group, split);
      if (!isNew) throw InputError(where, "{} {} is in '{}' already", by, group, entry->second);
    }
  }
  for (const std::string& group : groups) {
    if (!splits.contains(group)) {
      throw InputError(fields.where(), "{} {} is in no list: add it to train, val or test", by, group);
    }
  }
  return splits;
}

// Returns true if the splits are lists, false if they are shares. Throws InputError for a mixture or no splits.
bool usesLists(Fields& fields) {
  std::optional<bool> areLists;
  for (const char* split : kSplits) {
    const Value* value = fields.find(split);
    if (value == nullptr) continue;
    const bool isList = value->kind == Value::Kind::Sequence;
    if (areLists.value_or(isList) != isList) {
      throw InputError(value->where, "splits must be either all shares or all lists");
    }
    areLists = isList;
  }
  if (!areLists) throw InputError(fields.where(), "splits name no train, val or test{}", kAdvice);
  return *areLists;
}

}  // namespace

std::vector<std::string> assignSplits(const Value* value, const std::vector<SequenceName>& sequences,
                                      std::uint64_t seed) {
  if (value == nullptr || value->kind == Value::Kind::Null) return std::vector<std::string>(sequences.size(), "train");
  Fields fields(*value, "splits");
  fields.also({"by", "train", "val", "test"}).finish();
  const std::string by = fields.choice("by", {"seed", "trajectory"}, "seed");
  std::set<std::string> groups;
  for (const SequenceName& sequence : sequences) groups.insert(groupOf(sequence, by));
  const SplitOfGroup splits = usesLists(fields) ? byLists(fields, groups, by) : byShares(fields, groups, by, seed);
  std::vector<std::string> result;
  for (const SequenceName& sequence : sequences) result.push_back(splits.at(groupOf(sequence, by)));
  return result;
}

}  // namespace scanmill
