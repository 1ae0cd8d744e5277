#include "config/fields.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

#include "config/distribution.h"
#include "config/text.h"

namespace scanmill {

namespace {

// Returns what a value is, for messages, such as "nothing" for an empty value.
std::string description(const Value& value) {
  switch (value.kind) {
    case Value::Kind::Null:
      return "nothing";
    case Value::Kind::Sequence:
      return fmt::format("a list of {}", value.items.size());
    case Value::Kind::Map:
      return "a map";
    case Value::Kind::Scalar:
      break;
  }
  return quotedForMessage(value.text);
}

// Throws an InputError that says what the value must be (`expected`) and what it is. `what`: name of the value.
[[noreturn]] void refuse(const Value& value, std::string_view what, const std::string& expected) {
  if (isDistribution(value)) {
    throw InputError(value.where,
                     "{} cannot be random: only sensors' `mount` and `effects`, the pipeline's `effects` and a scene's "
                     "`objects` can (docs/keys.md); for a dataset of each value, run once for each with --set",
                     what);
  }
  std::string hint;
  if (value.kind == Value::Kind::Scalar) hint = value.quoted ? " in quotes, which is text" : numberAdvice(value.text);
  throw InputError(value.where, "{} must be {}, not {}{}", what, expected, description(value), hint);
}

// Returns the noun with its bounds, such as "a number from 1 to 5", but without a bound that is the type's limit.
template <class T>
std::string bounded(std::string_view noun, T low, T high, T lowest, T highest) {
  if (low == lowest && high == highest) return std::string(noun);
  if (high == highest) return fmt::format("{} of at least {}", noun, low);
  if (low == lowest) return fmt::format("{} of at most {}", noun, high);
  return fmt::format("{} from {} to {}", noun, low, high);
}

// Parses a decimal number. Returns false if `text` is no number, or has characters that are not in `characters`:
// from_chars() alone would accept inf and nan. Refuses leading zeros, since some readers of YAML take 017 for an octal
// number.
template <class T>
bool parseDecimal(std::string_view text, std::string_view characters, T& number) {
  if (text.find_first_not_of(characters) != std::string_view::npos) return false;
  const bool plus = text.starts_with('+');
  if (plus) text.remove_prefix(1);
  if (plus && text.starts_with('-')) return false;
  const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
  if (digits.size() > 1 && digits[0] == '0' && digits[1] >= '0' && digits[1] <= '9') return false;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end;
}

bool isPlain(const Value& value) {
  return value.kind == Value::Kind::Scalar && !value.quoted;
}

// Returns the word in lower case, with "_" for "-" and " ", so that nearest() ignores these differences.
std::string folded(std::string_view word) {
  std::string plain = lowerCase(word);
  std::replace_if(
      plain.begin(), plain.end(), [](char c) { return c == '-' || c == ' '; }, '_');
  return plain;
}

// Returns how many insertions, deletions, replacements and swaps of neighbours lead from a to b (optimal string
// alignment).
std::size_t editDistance(std::string_view a, std::string_view b) {
  // Three rows of the table whose entry (i, j) is the distance between the first i letters of a and the first j of b.
  std::vector<std::size_t> beforeLast(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], beforeLast[j - 2] + 1);
    }
    std::swap(beforeLast, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

// True if one word is a prefix of the other, such as `yaw` of `yaw_deg`, and both have at least three letters.
bool isPrefix(std::string_view a, std::string_view b) {
  return std::min(a.size(), b.size()) >= 3 && (a.starts_with(b) || b.starts_with(a));
}

// Returns the unit at the end of a name, such as "deg" of "yaw_deg"; empty if there is none.
std::string_view unitOf(std::string_view name) {
  static constexpr std::array<std::string_view, 9> kUnits{"s", "ms", "us", "ns", "m", "mm", "deg", "rad", "hz"};
  const std::size_t line = name.rfind('_');
  const std::string_view end = line == std::string_view::npos ? "" : name.substr(line + 1);
  return std::ranges::find(kUnits, end) == kUnits.end() ? "" : end;
}

constexpr double kFarthest = 1e9;  // m, largest coordinate
constexpr double kNearest = 1e-6;  // m, least distance between successive waypoints
constexpr double kSteepest = 85;   // deg, largest slope; a vertical path has no yaw
constexpr double kSharpest = 175;  // deg, largest turn at a waypoint; a path must not turn straight back

}  // namespace

Fields::Fields(const Value& value, std::string what) : value_(value), what_(std::move(what)) {
  if (value.kind == Value::Kind::Map || value.kind == Value::Kind::Null) return;
  throw InputError(value.where, "{} must be a map of keys and values, not {}", what_,
                   value.kind == Value::Kind::Scalar ? quotedForMessage(value.text) : "a list");
}

const Value* Fields::find(std::string_view key) const {
  if (std::ranges::find(known_, key) == known_.end()) known_.emplace_back(key);
  const Value* value = value_.find(key);
  return value != nullptr && value->kind != Value::Kind::Null ? value : nullptr;
}

const Value& Fields::require(std::string_view key) {
  if (const Value* value = find(key)) return *value;
  if (const Value* empty = value_.find(key)) return *empty;
  std::vector<std::string> unread;
  for (const auto& [other, value] : value_.entries) {
    if (std::ranges::find(known_, other) == known_.end()) unread.push_back(other);
  }
  const std::string typo = nearest(key, unread);
  if (!typo.empty()) refuseUnknown(typo, *value_.find(typo), suggestion(typo, {std::string(key)}));
  throw InputError(value_.where, "{}: the key '{}' is missing", what_, key);
}

double Fields::number(std::string_view key, Range range, std::optional<double> fallback) {
  if (fallback && find(key) == nullptr) return *fallback;
  return readNumber(require(key), fmt::format("{}: {}", what_, key), range);
}

std::int64_t Fields::integer(std::string_view key, std::int64_t low, std::int64_t high,
                             std::optional<std::int64_t> fallback) {
  if (fallback && find(key) == nullptr) return *fallback;
  return readInteger(require(key), fmt::format("{}: {}", what_, key), low, high);
}

bool Fields::boolean(std::string_view key, bool fallback) {
  const Value* value = find(key);
  return value != nullptr ? readBool(*value, fmt::format("{}: {}", what_, key)) : fallback;
}

std::string Fields::text(std::string_view key, std::optional<std::string_view> fallback) {
  if (fallback && find(key) == nullptr) return std::string(*fallback);
  return readText(require(key), fmt::format("{}: {}", what_, key));
}

std::string Fields::choice(std::string_view key, const std::vector<std::string>& names, std::string_view fallback) {
  const Value* value = find(key);
  if (value == nullptr) return std::string(fallback);
  std::string name = text(key);
  if (std::ranges::find(names, name) != names.end()) return name;
  throw InputError(value->where,
                   fmt::format("{}: {} may not be {}{}", what_, key, quotedForMessage(name), suggestion(name, names)));
}

Vec3d Fields::vec3(std::string_view key, const Vec3d& fallback) {
  const Value* value = find(key);
  return value != nullptr ? readVec3(*value, fmt::format("{}: {}", what_, key)) : fallback;
}

std::vector<double> Fields::numbers(std::string_view key, Range range) {
  return readNumbers(require(key), fmt::format("{}: {}", what_, key), range);
}

std::optional<Range> Fields::range(std::string_view key, Range limits) {
  const Value* const value = find(key);
  if (value == nullptr) return std::nullopt;
  const std::vector<double> ends = numbers(key, limits);
  if (ends.size() != 2 || ends[0] > ends[1]) {
    throw InputError(value->where, fmt::format("{0} must be [least, most], such as {0}: [0, 2.5]", key));
  }
  return Range{ends[0], ends[1]};
}

std::vector<std::string> Fields::texts(std::string_view key) {
  const Value* value = find(key);
  if (value == nullptr) return {};
  const std::string what = fmt::format("{}: {}", what_, key);
  if (value->kind == Value::Kind::Scalar) return {value->text};
  if (value->kind == Value::Kind::Map)
    throw InputError(value->where, what + " must be text or a list of texts, not a map");
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < value->items.size(); ++i) {
    texts.push_back(readText(value->items[i], fmt::format("{}[{}]", what, i)));
  }
  return texts;
}

std::string Fields::pathText(std::string_view key) {
  std::string name = text(key);
  if (!name.empty()) return name;
  throw InputError(require(key).where, "{}: {} must be a path, not an empty text", what_, key);
}

std::filesystem::path Fields::path(std::string_view key) {
  return resolvePath(require(key), pathText(key));
}

std::optional<std::filesystem::path> Fields::optionalPath(std::string_view key) {
  return find(key) == nullptr ? std::nullopt : std::optional(path(key));
}

std::filesystem::path Fields::resource(std::string_view key, const std::string& subfolder) {
  return resolveResource(require(key), pathText(key), subfolder);
}

std::optional<std::filesystem::path> Fields::optionalResource(std::string_view key, const std::string& subfolder) {
  return find(key) == nullptr ? std::nullopt : std::optional(resource(key, subfolder));
}

Pose Fields::pose() {
  Pose pose;
  pose.translation = vec3("position", {});
  const Value* rotation = find("rotation");
  const bool hasAngles = has("yaw_deg") || has("pitch_deg") || has("roll_deg");
  const double yaw = number("yaw_deg", {}, 0);
  const double pitch = number("pitch_deg", {}, 0);
  const double roll = number("roll_deg", {}, 0);
  if (rotation == nullptr) {
    pose.rotation = fromYawPitchRoll(radians(yaw), radians(pitch), radians(roll));
    return pose;
  }
  const std::string what = what_ + ": rotation";
  if (hasAngles) {
    throw InputError(rotation->where, what + " and yaw_deg, pitch_deg or roll_deg cannot be given together");
  }
  const std::vector<double> q = readNumbers(*rotation, what);
  if (q.size() != 4) {
    throw InputError(rotation->where,
                     fmt::format("{} must be a quaternion [w, x, y, z], not a list of {}", what, q.size()));
  }
  // Divides the quaternion by its largest component first, so that its squares neither overflow nor underflow.
  double largest = 0;
  for (const double c : q) largest = std::fmax(largest, std::fabs(c));
  if (largest == 0) throw InputError(rotation->where, what + " must be a quaternion [w, x, y, z] of non-zero length");
  Quat scaled{q[0] / largest, q[1] / largest, q[2] / largest, q[3] / largest};
  const double norm = std::sqrt(scaled.w * scaled.w + scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z);
  pose.rotation = {scaled.w / norm, scaled.x / norm, scaled.y / norm, scaled.z / norm};
  return pose;
}

Fields& Fields::also(std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) find(key);
  return *this;
}

Fields& Fields::alsoDescribed(std::string_view keys) {
  while (!keys.empty()) {
    also({keys.substr(0, keys.find(':'))});
    const std::size_t end = keys.find('\n');
    keys = end == std::string_view::npos ? std::string_view() : keys.substr(end + 1);
  }
  return *this;
}

void Fields::refuse(std::initializer_list<std::string_view> keys, std::string_view why) {
  for (const std::string_view key : keys) {
    if (const Value* value = find(key)) throw InputError(value->where, fmt::format("{}: {} {}", what_, key, why));
  }
}

void Fields::finish() const {
  for (const auto& [key, value] : value_.entries) {
    if (std::ranges::find(known_, key) != known_.end()) continue;
    refuseUnknown(key, value, suggestion(key, known_));
  }
}

void Fields::refuseUnknown(std::string_view key, const Value& value, const std::string& advice) const {
  const Location where = value.keyLine > 0 ? Location{value.where.file, value.keyLine, value.keyColumn} : value.where;
  throw InputError(where, "{}: unknown key {}{}", what_, quotedForMessage(key), advice);
}

double readNumber(const Value& value, std::string_view what, Range range) {
  double number = 0;
  const bool valid = isPlain(value) && parseDecimal(value.text, "+-.0123456789eE", number) && std::isfinite(number);
  if (!valid || number < range.low || number > range.high) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    refuse(value, what, bounded("a number", range.low, range.high, -kInfinity, kInfinity));
  }
  return number;
}

std::int64_t readInteger(const Value& value, std::string_view what, std::int64_t low, std::int64_t high) {
  std::int64_t number = 0;
  const bool valid = isPlain(value) && parseDecimal(value.text, "+-0123456789", number);
  if (!valid || number < low || number > high) {
    using Limits = std::numeric_limits<std::int64_t>;
    refuse(value, what, bounded("a whole number", low, high, Limits::min(), Limits::max()));
  }
  return number;
}

bool readBool(const Value& value, std::string_view what) {
  if (!isPlain(value) || (value.text != "true" && value.text != "false")) refuse(value, what, "true or false");
  return value.text == "true";
}

std::string readText(const Value& value, std::string_view what) {
  if (value.kind != Value::Kind::Scalar) refuse(value, what, "text");
  return value.text;
}

Vec3d readVec3(const Value& value, std::string_view what) {
  if (value.kind != Value::Kind::Sequence || value.items.size() != 3) {
    refuse(value, what, "a list of three numbers [x, y, z]");
  }
  const std::vector<double> numbers = readNumbers(value, what);
  return {numbers[0], numbers[1], numbers[2]};
}

const std::vector<Value>& readList(const Value& value, std::string_view what) {
  if (value.kind == Value::Kind::Sequence && !value.items.empty()) return value.items;
  throw InputError(value.where, "{} must be a list with at least one item", what);
}

std::vector<PlacedInteger> readIntegers(const Value& list, std::string_view what, std::int64_t low, std::int64_t high) {
  constexpr std::int64_t kMost = 1'000'000;  // maximum number of integers that one "..." may stand for
  if (list.kind != Value::Kind::Sequence) refuse(list, what, "a list of integers");
  std::vector<PlacedInteger> numbers;
  numbers.reserve(list.items.size());
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const Value& item = list.items[i];
    if (item.text != "...") {
      numbers.push_back({readInteger(item, what, low, high), item.where});
      continue;
    }
    if (numbers.empty() || i + 1 == list.items.size()) {
      throw InputError(item.where, "{}: '...' must be between two numbers, such as [1, ..., 20]", what);
    }
    const std::int64_t first = numbers.back().value;
    const std::int64_t last =
        readInteger(list.items[i + 1], what, first + 1, first > high - kMost ? high : first + kMost);
    for (std::int64_t n = first + 1; n < last; ++n) numbers.push_back({n, item.where});
  }
  return numbers;
}

std::vector<double> readNumbers(const Value& value, std::string_view what, Range range) {
  if (value.kind != Value::Kind::Sequence) refuse(value, what, "a list of numbers");
  std::vector<double> numbers;
  numbers.reserve(value.items.size());
  for (std::size_t i = 0; i < value.items.size(); ++i) {
    numbers.push_back(readNumber(value.items[i], fmt::format("{}[{}]", what, i), range));
  }
  return numbers;
}

NamedOptions readNamed(const Value& value, const std::string& what) {
  NamedOptions named{"", value.where, {}};
  named.options.where = value.where;
  if (value.kind == Value::Kind::Map && value.entries.size() == 1) {
    named.name = value.entries.front().key;
    named.options = value.entries.front().value;
    return named;
  }
  if (value.kind != Value::Kind::Scalar) {
    throw InputError(value.where, "{} must be a name or one pair `name: {{options}}`", what);
  }
  named.name = readText(value, what);
  return named;
}

std::string nearest(std::string_view word, const std::vector<std::string>& names) {
  constexpr std::size_t kLongestWord = 100;
  if (word.empty() || word.size() > kLongestWord) return {};
  const std::string foldedWord = folded(word);
  std::string best;
  std::size_t leastCost = 0;
  for (const std::string& name : names) {
    const std::string foldedName = folded(name);
    const std::size_t distance = editDistance(foldedWord, foldedName);
    const std::size_t longest = std::max(foldedWord.size(), foldedName.size());
    const bool hasPrefix = isPrefix(foldedWord, foldedName);
    // A name is near if its edit distance is at most a third of the longer word, or 1; or if one word is a prefix of
    // the other. A name of which all letters differ is not near.
    if ((distance > std::max<std::size_t>(1, longest / 3) && !hasPrefix) || distance == longest) continue;
    // A name that is a prefix of the word, or begins with the word, is nearer than others at the same edit distance.
    const std::size_t cost = 2 * distance - (distance > 0 && hasPrefix ? 1 : 0);
    if (best.empty() || cost < leastCost) {
      best = name;
      leastCost = cost;
    }
  }
  return best;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& names) {
  if (names.empty()) return {};
  const std::string name = nearest(word, names);
  const std::string_view unit = unitOf(name), wordUnit = unitOf(word);
  if (unit != wordUnit && !unit.empty() && !wordUnit.empty()) {
    return fmt::format(" (did you mean '{}'? Its unit is {}, not {})", name, unit, wordUnit);
  }
  if (!name.empty()) return fmt::format(" (did you mean '{}'?)", name);
  return fmt::format(" (known: {})", fmt::join(names, ", "));
}

Vec3d checkedPosition(const Vec3d& position, const Location& where) {
  if (std::fabs(position.x) > kFarthest || std::fabs(position.y) > kFarthest || std::fabs(position.z) > kFarthest) {
    throw InputError(where, "position [{:g}, {:g}, {:g}] is farther than {:g} m from the origin", position.x,
                     position.y, position.z, kFarthest);
  }
  return position;
}

std::vector<Vec3d> readWaypoints(const Value& value, Climbs climbs) {
  if (value.kind != Value::Kind::Sequence || value.items.size() < 2) {
    throw InputError(
        value.where,
        "waypoints must be a list of at least two positions such as [[0, 0, 0], [50, 0, 0]]; for a vehicle "
        "that stands still use poses");
  }
  std::vector<Vec3d> points;
  points.reserve(value.items.size());
  for (const Value& item : value.items) {
    points.push_back(checkedPosition(readVec3(item, "waypoint"), item.where));
    if (climbs == Climbs::No) points.back().z = points.front().z;
    const std::size_t last = points.size() - 1;
    if (last < 1) continue;
    const Vec3d chord = points[last] - points[last - 1];
    if (length(chord) < kNearest) {
      throw InputError(item.where, "waypoint {} repeats the one before it; remove one of them", last + 1);
    }
    if (std::fabs(chord.z) > length(chord) * std::sin(radians(kSteepest))) {
      throw InputError(item.where,
                       "the path to waypoint {} is steeper than {} deg: a vehicle that heads "
                       "along it would have no yaw; use poses",
                       last + 1, kSteepest);
    }
    if (last < 2) continue;
    const Vec3d previousChord = points[last - 1] - points[last - 2];
    if (dot(normalized(previousChord), normalized(chord)) < std::cos(radians(kSharpest))) {
      throw InputError(value.items[last - 1].where,
                       "the path goes straight back at waypoint {}; add waypoints that make the turn", last);
    }
  }
  return points;
}

}  // namespace scanmill
