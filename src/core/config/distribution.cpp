#include "config/distribution.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <boost/math/special_functions/erf.hpp>
#include <charconv>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/hash.h"
#include "base/random.h"
#include "config/fields.h"

namespace scanmill {

namespace {

constexpr std::array kKinds{std::string_view("uniform"), std::string_view("normal"), std::string_view("choice")};
constexpr double kMostDeviations = 4;  // a normal distribution is cut off at this multiple of its standard deviation

// Reads an interval [low, high]. Throws InputError unless low is below high.
Range readInterval(const Value& value, std::string_view what) {
  const std::vector<double> ends = readNumbers(value, what);
  if (ends.size() == 2 && ends[0] < ends[1]) return {ends[0], ends[1]};
  throw InputError(value.where, "{} must be [least, most], the first below the second", what);
}

// Returns the probability that a standard normal value is below `value`. normalQuantile() is the inverse.
double normalProbability(double value) {
  return std::erfc(-value / std::numbers::sqrt2) / 2;
}

double normalQuantile(double probability) {
  return -std::numbers::sqrt2 * boost::math::erfc_inv(2 * probability);
}

struct Normal {
  double mean, deviation;  // deviation: standard deviation
  Range ends;              // the distribution is cut off outside of this interval
};

Normal readNormal(Fields& fields) {
  const Value& value = fields.require("normal");
  const std::vector<double> parameters = readNumbers(value, "normal");
  if (parameters.size() != 2 || parameters[1] <= 0) {
    throw InputError(value.where, "normal must be [mean, standard deviation] with a standard deviation above 0");
  }
  const double mean = parameters[0], deviation = parameters[1];
  Range ends{mean - kMostDeviations * deviation, mean + kMostDeviations * deviation};
  if (const Value* within = fields.find("within")) {
    const Range bounds = readInterval(*within, "within");
    ends = {std::max(ends.low, bounds.low), std::min(ends.high, bounds.high)};
    if (ends.low >= ends.high) {
      throw InputError(within->where, fmt::format("within excludes all values of the distribution: [{:g}, {:g}] is "
                                                  "more than {:g} standard deviations from the mean",
                                                  bounds.low, bounds.high, kMostDeviations));
    }
  }
  return {mean, deviation, ends};
}

// Returns the quantile `random` (0 to 1) of the truncated normal distribution: a sample if `random` is uniform.
double sampleNormal(const Normal& normal, double random) {
  const double low = normalProbability((normal.ends.low - normal.mean) / normal.deviation);
  const double high = normalProbability((normal.ends.high - normal.mean) / normal.deviation);
  return std::clamp(normal.mean + normal.deviation * normalQuantile(low + (high - low) * random), normal.ends.low,
                    normal.ends.high);
}

// Returns a scalar with this text, which replaces `distribution` and keeps its key and its position in the file.
Value scalar(const Value& distribution, std::string text) {
  Value value = distribution;
  value.kind = Value::Kind::Scalar;
  value.text = std::move(text);
  value.entries = {};
  return value;
}

// Returns the integers that a choice such as [1, ..., 9] stands for; empty if the choice has no "...".
std::vector<PlacedInteger> readSpan(const Value& list) {
  const std::vector<Value>& items = readList(list, "choice");
  const bool spans = std::ranges::any_of(
      items, [](const Value& item) { return item.kind == Value::Kind::Scalar && !item.quoted && item.text == "..."; });
  constexpr std::int64_t kMost = 1'000'000'000'000;
  return spans ? readIntegers(list, "choice", -kMost, kMost) : std::vector<PlacedInteger>{};
}

// Returns the item `index` of the choice `list`, with the key position of `distribution` for messages.
Value itemOf(const Value& distribution, const Value& list, std::size_t index) {
  Value item = list.items[index];
  item.keyLine = distribution.keyLine;
  item.keyColumn = distribution.keyColumn;
  return item;
}

// Returns the weights of the items of a choice; empty if all are equally likely. Throws InputError unless there is a
// weight for each item and one of them is positive.
std::vector<double> readWeights(Fields& fields) {
  constexpr Range kLimits{0, 1e12};  // sums of larger weights would not be exact
  const Value* const value = fields.find("weights");
  if (value == nullptr) return {};
  const Value& list = fields.require("choice");
  const std::size_t items = std::max(readSpan(list).size(), list.items.size());
  std::vector<double> weights = readNumbers(*value, "weights");
  const auto isAllowed = [&](double weight) { return kLimits.contains(weight); };
  if (weights.size() != items || !std::ranges::all_of(weights, isAllowed) || std::ranges::max(weights) == 0) {
    throw InputError(value->where, fmt::format("weights must be {} numbers of at least 0, one for each item of the "
                                               "choice and not all of them 0",
                                               items));
  }
  return weights;
}

// Returns the index of the item that the random number `random` (0 to 1) selects. `weights`: one per item; empty if all
// items are equally likely.
std::size_t sampleIndex(const std::vector<double>& weights, std::size_t items, double random) {
  if (weights.empty()) return std::min(static_cast<std::size_t>(random * static_cast<double>(items)), items - 1);
  double remaining = random * std::accumulate(weights.begin(), weights.end(), 0.0);
  std::size_t selected = 0;  // if rounding errors leave a remainder, the last item with a positive weight
  for (std::size_t i = 0; i < items; ++i) {
    if (weights[i] <= 0) continue;
    selected = i;
    if (remaining < weights[i]) break;
    remaining -= weights[i];
  }
  return selected;
}

Value sampleChoice(Fields& fields, double random) {
  const Value& list = fields.require("choice");
  const std::vector<double> weights = readWeights(fields);
  const std::vector<PlacedInteger> span = readSpan(list);
  if (span.empty()) return itemOf(fields.value(), list, sampleIndex(weights, list.items.size(), random));
  return scalar(fields.value(), std::to_string(span[sampleIndex(weights, span.size(), random)].value));
}

bool isPerFrame(Fields& fields) {
  return fields.choice("per", {"sequence", "frame"}, "sequence") == "frame";
}

bool isStratified(Fields& fields) {
  return fields.choice("stratify", {"none", "split"}, "none") == "split";
}

// Returns the keys of a distribution. Throws InputError unless exactly one of them is `uniform`, `normal` or `choice`.
Fields fieldsOf(const Value& value) {
  Fields fields(value, "distribution");
  fields.also({"uniform", "normal", "choice", "weights", "within", "per", "stratify"}).finish();
  const auto kinds = std::ranges::count_if(kKinds, [&](std::string_view kind) { return fields.has(kind); });
  if (kinds != 1) throw InputError(value.where, "a distribution must be exactly one of uniform, normal and choice");
  if (!fields.has("normal")) fields.refuse({"within"}, "can only limit a normal distribution");
  if (!fields.has("choice")) fields.refuse({"weights"}, "can only be given to a choice");
  isPerFrame(fields);
  isStratified(fields);
  return fields;
}

// Returns the value that the random number `random` (0 to 1) selects. `fields`: the result of fieldsOf().
Value sample(Fields& fields, double random) {
  if (fields.has("choice")) return sampleChoice(fields, random);
  if (fields.has("normal")) {
    return scalar(fields.value(), fmt::format("{}", sampleNormal(readNormal(fields), random)));
  }
  const Range ends = readInterval(fields.require("uniform"), "uniform");
  const double number = std::clamp(std::lerp(ends.low, ends.high, random), ends.low, ends.high);
  return scalar(fields.value(), fmt::format("{}", number));
}

// Returns the end (see countCases()) that the case `caseNumber` puts in place of a distribution. If the end is an item
// of a choice, sets `caseNumber` to the case number for the distributions within this item.
Value endOf(const Value& value, std::size_t& caseNumber) {
  Fields fields = fieldsOf(value);
  const bool isLowEnd = caseNumber % 2 == 0;
  if (!fields.has("choice")) {
    const Range ends =
        fields.has("normal") ? readNormal(fields).ends : readInterval(fields.require("uniform"), "uniform");
    return scalar(value, fmt::format("{}", isLowEnd ? ends.low : ends.high));
  }
  const Value& list = fields.require("choice");
  readWeights(fields);  // throws if the weights are invalid
  const std::vector<PlacedInteger> span = readSpan(list);
  if (!span.empty()) {
    const auto [low, high] = std::ranges::minmax_element(span, {}, &PlacedInteger::value);
    return scalar(value, std::to_string(isLowEnd ? low->value : high->value));
  }
  const std::size_t item = caseNumber % list.items.size();
  caseNumber /= list.items.size();
  return itemOf(value, list, item);
}

std::uint32_t hashOf(const std::string& text) {
  return static_cast<std::uint32_t>(std::stoul(xxh3(text).substr(0, 8), nullptr, 16));
}

// Returns the image of `index` under a random permutation of the numbers below `count`. A Feistel network of four
// rounds (Luby and Rackoff, SIAM J. Comput. 17, 1988) permutes the numbers below the next power of four. The network is
// applied again until the result is below `count`.
std::uint64_t permuted(std::uint64_t index, std::uint64_t count, RandomAddress address) {
  unsigned halfBits = 1;  // an index has twice as many bits: an upper and a lower half
  while (count > std::uint64_t{1} << (2 * halfBits)) ++halfBits;
  const std::uint64_t mask = (std::uint64_t{1} << halfBits) - 1;
  address.purpose = Purpose::Stratum;
  do {
    std::uint64_t upper = index >> halfBits;
    std::uint64_t lower = index & mask;
    for (std::uint32_t round = 0; round < 4; ++round) {
      address.sensor = round;
      address.frame = static_cast<std::uint32_t>(lower);
      upper = std::exchange(lower, upper ^ (randomBlock(address)[0] & mask));
    }
    index = upper << halfBits | lower;
  } while (index >= count);
  return index;
}

// Returns the random number (0 to 1) that selects the value of a key. `fields`: the key's distribution. `place`:
// position of the sequence and the frame in their split, which stratified distributions use.
double randomNumberOf(const std::string& key, RandomAddress address, Fields& fields, const PlaceInSplit& place) {
  const bool perFrame = isPerFrame(fields);
  const bool stratified = isStratified(fields);
  address.beam = hashOf(key);
  address.purpose = Purpose::Distribution;
  if (stratified) address.scene = hashOf(place.split);
  if (stratified || !perFrame) address.frame = 0;
  const double random = uniform(randomBlock(address)[0]);
  if (!stratified) return random;
  const std::uint64_t count = perFrame ? place.frames : place.sequences;
  const std::uint64_t stratum = permuted(perFrame ? place.frame : place.sequence, count, address);
  return (static_cast<double>(stratum) + random) / static_cast<double>(count);
}

// Calls apply() for each item and each entry of a value, but not for the values within these.
void forEachWithin(const Value& value, const auto& apply) {
  for (const Value& item : value.items) apply(item);
  for (const Value::Entry& entry : value.entries) apply(entry.value);
}

// Appends to `draws` an entry for each scalar and each empty value within `value`, which was sampled for `key`.
void addValues(const Value& value, const std::string& key, std::vector<DrawnValue>& draws) {
  for (std::size_t i = 0; i < value.items.size(); ++i) {
    addValues(value.items[i], fmt::format("{}.{}", key, i), draws);
  }
  for (const Value::Entry& entry : value.entries) addValues(entry.value, key + "." + entry.key, draws);
  if (!value.items.empty() || !value.entries.empty()) return;
  double number = 0;
  const char* const end = value.text.data() + value.text.size();
  const auto [last, failure] = std::from_chars(value.text.data(), end, number);
  const bool isNumber = value.kind == Value::Kind::Scalar && !value.quoted && failure == std::errc() && last == end &&
                        std::isfinite(number);
  draws.push_back(isNumber ? DrawnValue{key, fmt::format("{}", number), true} : DrawnValue{key, flowText(value)});
}

// Returns the first distribution within the value for whose keys `matches` returns true; null if there is none.
const Value* findDistribution(const Value& value, bool (*matches)(Fields&)) {
  if (isDistribution(value)) {
    Fields fields = fieldsOf(value);
    if (matches(fields)) return &value;
  }
  const Value* found = nullptr;
  forEachWithin(value, [&](const Value& child) {
    if (found == nullptr) found = findDistribution(child, matches);
  });
  return found;
}

}  // namespace

bool isDistribution(const Value& value) {
  return value.kind == Value::Kind::Map && std::ranges::any_of(value.entries, [](const auto& e) {
           return std::ranges::find(kKinds, e.key) != kKinds.end();
         });
}

bool holdsDistribution(const Value& value) {
  bool holds = isDistribution(value);
  forEachWithin(value, [&](const Value& child) { holds = holds || holdsDistribution(child); });
  return holds;
}

const Value* findDrawnPerFrame(const Value& value) {
  return findDistribution(value, isPerFrame);
}

const Value* findStratified(const Value& value) {
  return findDistribution(value, isStratified);
}

Value withDraws(const Value& value, const std::string& key, const RandomAddress& address,
                std::vector<DrawnValue>& draws, const PlaceInSplit& place) {
  if (isDistribution(value)) {
    Value sampled = value;
    RandomAddress numbered = address;
    // An item of a choice may itself be a distribution. Nested distributions get successive numbers below 16.
    for (numbered.number = 0; isDistribution(sampled); numbered.number = (numbered.number + 1) % 16) {
      Fields fields = fieldsOf(sampled);
      sampled = sample(fields, randomNumberOf(key, numbered, fields, place));
    }
    std::vector<DrawnValue> inner;  // discarded: the entries in `draws` show the complete item
    sampled = withDraws(sampled, key, address, inner, place);
    addValues(sampled, key, draws);
    return sampled;
  }
  const std::string prefix = key.empty() ? "" : key + ".";
  Value copy = value;
  for (std::size_t i = 0; i < copy.items.size(); ++i) {
    copy.items[i] = withDraws(value.items[i], prefix + std::to_string(i), address, draws, place);
  }
  for (Value::Entry& entry : copy.entries) {
    entry.value = withDraws(entry.value, prefix + entry.key, address, draws, place);
  }
  return copy;
}

std::size_t countCases(const Value& value) {
  std::size_t casesWithin = 1;
  forEachWithin(value, [&](const Value& child) { casesWithin = std::max(casesWithin, countCases(child)); });
  if (!isDistribution(value)) return casesWithin;
  Fields fields = fieldsOf(value);
  if (!fields.has("choice")) return 2;
  const Value& list = fields.require("choice");
  return readSpan(list).empty() ? list.items.size() * casesWithin : 2;
}

Value withCase(const Value& value, std::size_t caseNumber) {
  Value copy = value;
  while (isDistribution(copy)) copy = endOf(copy, caseNumber);
  for (Value& item : copy.items) item = withCase(item, caseNumber);
  for (Value::Entry& entry : copy.entries) entry.value = withCase(entry.value, caseNumber);
  return copy;
}

}  // namespace scanmill
