#include "config/distribution.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/hash.h"
#include "base/random.h"
#include "config/fields.h"
#include "config/flow_text.h"

namespace scanmill {

namespace {

constexpr std::array kKinds{std::string_view("uniform"), std::string_view("normal"), std::string_view("choice")};
constexpr double kMostDeviations = 4;

// Reads an interval [low, high]. Throws InputError unless low is below high.
Range readInterval(const Value& value, std::string_view what) {
  const std::vector<double> ends = readNumbers(value, what);
  if (ends.size() == 2 && ends[0] < ends[1]) return {ends[0], ends[1]};
  throw InputError(value.where, fmt::format("{} must be [least, most], the first below the second", what));
}

// Returns the probability that a standard normal value is below `deviations`. deviationsAt() is the inverse.
double shareBelow(double deviations) {
  return std::erfc(-deviations / std::numbers::sqrt2) / 2;
}

double deviationsAt(double share) {
  return -std::numbers::sqrt2 * boost::math::erfc_inv(2 * share);
}

struct Normal {
  double mean = 0;
  double deviation = 1;
  Range ends{0, 0};  // the distribution is cut off outside of this interval
};

Normal readNormal(Fields& fields) {
  const Value& value = fields.require("normal");
  const std::vector<double> given = readNumbers(value, "normal");
  if (given.size() != 2 || given[1] <= 0) {
    throw InputError(value.where, "normal must be [mean, standard deviation] with a standard deviation above 0");
  }
  const double mean = given[0];
  const double deviation = given[1];
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

double drawNormal(const Normal& normal, double random) {
  const double low = shareBelow((normal.ends.low - normal.mean) / normal.deviation);
  const double high = shareBelow((normal.ends.high - normal.mean) / normal.deviation);
  return std::clamp(normal.mean + normal.deviation * deviationsAt(low + (high - low) * random), normal.ends.low,
                    normal.ends.high);
}

Value scalar(const Value& distribution, std::string text) {
  Value value = distribution;
  value.kind = Value::Kind::Scalar;
  value.text = std::move(text);
  value.entries = {};
  return value;
}

// Returns the integers of a choice such as [1, ..., 9], written with "..." between two integers; empty if the choice is
// a list of items.
std::vector<PlacedInteger> readSpan(const Value& list) {
  if (list.kind != Value::Kind::Sequence || list.items.empty()) {
    throw InputError(list.where, "choice must be a list with at least one item");
  }
  const bool spans = std::any_of(list.items.begin(), list.items.end(), [](const Value& item) {
    return item.kind == Value::Kind::Scalar && !item.quoted && item.text == "...";
  });
  constexpr std::int64_t kMost = 1'000'000'000'000;
  return spans ? readIntegers(list, "choice", -kMost, kMost) : std::vector<PlacedInteger>{};
}

// Returns an item of the choice. Its key, for messages, is the key of the distribution.
Value itemOf(const Value& distribution, const Value& list, std::size_t index) {
  Value item = list.items[index];
  item.keyLine = distribution.keyLine;
  item.keyColumn = distribution.keyColumn;
  return item;
}

// Returns the weights of the items of a choice; empty if all are equally likely. Throws InputError unless there is a
// weight for each item and one of them is positive.
std::vector<double> readWeights(Fields& fields) {
  const Value* const given = fields.find("weights");
  if (given == nullptr) return {};
  const Value& list = fields.require("choice");
  const std::size_t items = std::max(readSpan(list).size(), list.items.size());
  std::vector<double> weights = readNumbers(*given, "weights");
  const bool good = weights.size() == items &&
                    std::all_of(weights.begin(), weights.end(), [](double w) { return w >= 0 && w < 1e12; }) &&
                    std::any_of(weights.begin(), weights.end(), [](double w) { return w > 0; });
  if (!good) {
    throw InputError(given->where, fmt::format("weights must be {} numbers of at least 0, one for each item of the "
                                               "choice and not all of them 0",
                                               items));
  }
  return weights;
}

Value drawChoice(Fields& fields, double random) {
  const Value& distribution = fields.value();
  const Value& list = fields.require("choice");
  const std::vector<double> weights = readWeights(fields);
  const auto pick = [&](std::size_t count) {
    if (weights.empty()) return std::min(static_cast<std::size_t>(random * static_cast<double>(count)), count - 1);
    double left = random * std::accumulate(weights.begin(), weights.end(), 0.0);
    std::size_t last = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (weights[i] <= 0) continue;
      last = i;
      if (left < weights[i]) break;
      left -= weights[i];
    }
    return last;
  };
  const std::vector<PlacedInteger> span = readSpan(list);
  if (!span.empty()) return scalar(distribution, std::to_string(span[pick(span.size())].value));
  return itemOf(distribution, list, pick(list.items.size()));
}

bool isPerFrame(Fields& fields) {
  return fields.choice("per", {"sequence", "frame"}, "sequence") == "frame";
}

// Returns the keys of a distribution, after a check that exactly one of them is `uniform`, `normal` or `choice`.
Fields fieldsOf(const Value& value) {
  Fields fields(value, "distribution");
  fields.also({"uniform", "normal", "choice", "weights", "within", "per"}).finish();
  const auto kinds =
      std::count_if(kKinds.begin(), kKinds.end(), [&](std::string_view kind) { return fields.has(kind); });
  if (kinds != 1) throw InputError(value.where, "a distribution must be exactly one of uniform, normal and choice");
  if (const Value* within = fields.find("within"); within != nullptr && !fields.has("normal")) {
    throw InputError(within->where, "within can only limit a normal distribution");
  }
  if (const Value* weights = fields.find("weights"); weights != nullptr && !fields.has("choice")) {
    throw InputError(weights->where, "weights can only be given to a choice");
  }
  isPerFrame(fields);
  return fields;
}

Value draw(Fields& fields, double random) {
  const Value& value = fields.value();
  if (fields.has("normal")) return scalar(value, fmt::format("{}", drawNormal(readNormal(fields), random)));
  if (fields.has("choice")) return drawChoice(fields, random);
  const Range ends = readInterval(fields.require("uniform"), "uniform");
  return scalar(value, fmt::format("{}", std::clamp(std::lerp(ends.low, ends.high, random), ends.low, ends.high)));
}

// Returns the end (see countCases()) that a distribution takes in the case `number`. If the end is an item of a choice,
// `number` becomes the number of the case for distributions within the item.
Value endOf(const Value& value, std::size_t& number) {
  Fields fields = fieldsOf(value);
  const std::size_t which = number;
  if (!fields.has("choice")) {
    const Range ends =
        fields.has("normal") ? readNormal(fields).ends : readInterval(fields.require("uniform"), "uniform");
    return scalar(value, fmt::format("{}", which % 2 == 0 ? ends.low : ends.high));
  }
  const Value& list = fields.require("choice");
  readWeights(fields);
  const std::vector<PlacedInteger> span = readSpan(list);
  if (!span.empty()) {
    const auto [low, high] =
        std::minmax_element(span.begin(), span.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
    return scalar(value, std::to_string(which % 2 == 0 ? low->value : high->value));
  }
  number = which / list.items.size();
  return itemOf(value, list, which % list.items.size());
}

double randomOf(const std::string& key, RandomAddress address) {
  address.beam = static_cast<std::uint32_t>(std::stoul(xxh3(key).substr(0, 8), nullptr, 16));
  address.purpose = Purpose::Distribution;
  return uniform(randomBlock(address)[0]);
}

// Calls apply() for each item or entry of a value, without descending into them.
template <class Do>
void forEachWithin(const Value& value, const Do& apply) {
  for (const Value& item : value.items) apply(item);
  for (const Value::Entry& entry : value.entries) apply(entry.value);
}

}  // namespace

bool isDistribution(const Value& value) {
  return value.kind == Value::Kind::Map && std::any_of(value.entries.begin(), value.entries.end(), [](const auto& e) {
           return std::find(kKinds.begin(), kKinds.end(), e.key) != kKinds.end();
         });
}

bool holdsDistribution(const Value& value) {
  bool holds = isDistribution(value);
  forEachWithin(value, [&](const Value& part) { holds = holds || holdsDistribution(part); });
  return holds;
}

const Value* findDrawnPerFrame(const Value& value) {
  if (isDistribution(value)) {
    Fields fields = fieldsOf(value);
    if (isPerFrame(fields)) return &value;
  }
  const Value* found = nullptr;
  forEachWithin(value, [&](const Value& part) { found = found == nullptr ? findDrawnPerFrame(part) : found; });
  return found;
}

Value withDraws(const Value& value, const std::string& key, const RandomAddress& address,
                std::vector<DrawnValue>& draws) {
  if (isDistribution(value)) {
    Value one = value;
    RandomAddress own = address;
    // An item of a choice may be a distribution, too.
    for (own.number = 0; isDistribution(one); own.number = (own.number + 1) % 16) {
      Fields fields = fieldsOf(one);
      own.frame = isPerFrame(fields) ? address.frame : 0;
      one = draw(fields, randomOf(key, own));
    }
    std::vector<DrawnValue> within;  // not reported: the entry in `draws` shows the complete item
    one = withDraws(one, key, address, within);
    draws.push_back({key, flowText(one)});
    return one;
  }
  const std::string before = key.empty() ? "" : key + ".";
  Value copy = value;
  for (std::size_t i = 0; i < copy.items.size(); ++i) {
    copy.items[i] = withDraws(value.items[i], before + std::to_string(i), address, draws);
  }
  for (Value::Entry& entry : copy.entries) {
    entry.value = withDraws(entry.value, before + entry.key, address, draws);
  }
  return copy;
}

std::size_t countCases(const Value& value) {
  std::size_t within = 1;
  forEachWithin(value, [&](const Value& part) { within = std::max(within, countCases(part)); });
  if (!isDistribution(value)) return within;
  Fields fields = fieldsOf(value);
  if (!fields.has("choice")) return 2;
  const Value& list = fields.require("choice");
  return readSpan(list).empty() ? list.items.size() * within : 2;
}

Value withCase(const Value& value, std::size_t number) {
  Value copy = value;
  while (isDistribution(copy)) copy = endOf(copy, number);
  for (Value& item : copy.items) item = withCase(item, number);
  for (Value::Entry& entry : copy.entries) entry.value = withCase(entry.value, number);
  return copy;
}

}  // namespace scanmill
