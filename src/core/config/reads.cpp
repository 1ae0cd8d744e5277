// Reads one value as a certain type.

#include <fmt/core.h>

#include <charconv>
#include <limits>

#include "config/distribution.h"
#include "config/fields.h"
#include "config/text.h"

namespace scanmill {

namespace {

// Describes a value, for messages.
std::string found(const Value& value) {
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

[[noreturn]] void refuse(const Value& value, std::string_view what, const std::string& expected) {
  if (isDistribution(value)) {
    throw InputError(
        value.where,
        fmt::format("{} cannot be random: only sensors' `mount` and `effects`, the pipeline's `effects` and a scene's "
                    "`objects` can (docs/keys.md); `--sweep` makes a dataset for each of several values",
                    what));
  }
  std::string hint;
  if (value.kind == Value::Kind::Scalar) hint = value.quoted ? " in quotes, which is text" : numberAdvice(value.text);
  throw InputError(value.where, fmt::format("{} must be {}, not {}{}", what, expected, found(value), hint));
}

// Returns "a number from 1 to 5", or less if the interval [low, high] ends where the type's [lowest, highest] does.
template <class T>
std::string bounded(std::string_view noun, T low, T high, T lowest, T highest) {
  if (low == lowest && high == highest) return std::string(noun);
  if (high == highest) return fmt::format("{} of at least {}", noun, low);
  if (low == lowest) return fmt::format("{} of at most {}", noun, high);
  return fmt::format("{} from {} to {}", noun, low, high);
}

// Reads all of `text` as a decimal number; returns false if it is not a number. from_chars() alone would also accept
// inf and nan. Leading zeros are refused, since some readers of YAML take 017 for an octal number.
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

}  // namespace

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
  throw InputError(value.where, fmt::format("{} must be a list with at least one item", what));
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
      throw InputError(item.where, fmt::format("{}: '...' must be between two numbers, such as [1, ..., 20]", what));
    }
    const std::int64_t from = numbers.back().value;
    const std::int64_t to = readInteger(list.items[i + 1], what, from + 1, from > high - kMost ? high : from + kMost);
    for (std::int64_t n = from + 1; n < to; ++n) numbers.push_back({n, item.where});
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
    throw InputError(value.where, fmt::format("{} must be a name or one pair `name: {{options}}`", what));
  }
  named.name = readText(value, what);
  return named;
}

}  // namespace scanmill
