#include "town/osm.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>

#include "config/text.h"

namespace scanmill::town {
namespace {

// Takes a number without a sign and the blanks around it from the front of a text.
std::optional<double> takeNumber(std::string_view& text) {
  constexpr std::string_view kDigits = "0123456789";
  const auto skipBlanks = [&] { text.remove_prefix(std::min(text.find_first_not_of(' '), text.size())); };
  skipBlanks();
  std::string digits(text.substr(0, std::min(text.find_first_not_of("0123456789.,"), text.size())));
  if (const std::size_t comma = digits.find(','); comma != std::string::npos) {
    const std::size_t after = digits.size() - comma - 1;
    if (after < 1 || after > 2 || digits.find('.') != std::string::npos) return std::nullopt;
    digits[comma] = '.';
  }
  if (digits.find_first_of(kDigits) == std::string::npos) return std::nullopt;
  double number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  text.remove_prefix(digits.size());
  skipBlanks();
  return number;
}

}  // namespace

bool isOneOf(std::string_view value, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), value) != words.end();
}

std::optional<double> metresOf(std::string_view value) {
  constexpr double kFoot = 0.3048;  // m
  static const std::map<std::string_view, double> kUnits = {
      {"", 1},         {"m", 1},     {"metre", 1},       {"metres", 1},     {"meter", 1},  {"meters", 1},
      {"km", 1000},    {"cm", 0.01}, {"mm", 0.001},      {"mi", 1609.344},  {"nmi", 1852}, {"ft", kFoot},
      {"feet", kFoot}, {"'", kFoot}, {"in", kFoot / 12}, {"\"", kFoot / 12}};
  const std::optional<double> number = takeNumber(value);
  if (!number) return std::nullopt;
  if (const auto unit = kUnits.find(value); unit != kUnits.end()) return unit->second * *number;
  for (const std::string_view foot : {"'", "ft"}) {
    if (!value.starts_with(foot)) continue;
    value.remove_prefix(foot.size());
    const std::optional<double> inches = takeNumber(value);
    if (inches && isOneOf(value, {"\"", "in"})) return kFoot * (*number + *inches / 12);
  }
  return std::nullopt;
}

std::optional<double> numberOf(std::string_view value) {
  const std::optional<double> number = takeNumber(value);
  return value.empty() ? number : std::nullopt;
}

std::optional<double> compassOf(std::string_view value) {
  constexpr std::string_view kPoints[] = {"N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE",
                                          "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"};
  const auto* const point = std::find(std::begin(kPoints), std::end(kPoints), value);
  if (point != std::end(kPoints)) return 22.5 * static_cast<double>(point - kPoints);
  return numberOf(value);
}

std::optional<double> TagNumbers::read(const OsmTags& tags, const char* key, Parse parse, double least, double most) {
  const std::string& value = tags[key];
  if (value.empty()) return std::nullopt;
  const std::optional<double> number = parse(value);
  if (number && *number >= least && *number <= most) return number;
  Unusable& unusable = unusable_[key];
  if (unusable.count++ == 0) unusable.example = fmt::format("{} of {}", quotedForMessage(value), tags.element);
  return std::nullopt;
}

void TagNumbers::tell(LeftOut& leftOut) const {
  for (const auto& [key, unusable] : unusable_) {
    leftOut.add(fmt::format("values of {} that cannot be used, such as {}", key, unusable.example), unusable.count);
  }
}

}  // namespace scanmill::town
