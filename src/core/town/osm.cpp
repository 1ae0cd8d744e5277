#include "town/osm.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>

#include "base/text_scan.h"
#include "config/text.h"

namespace scanmill::town {
namespace {

// Takes a number without a sign and the blanks around it from the front of a text.
std::optional<double> takeNumber(std::string_view& text) {
  text = trimmed(text);
  if (text.empty() || std::string_view("0123456789.").find(text.front()) == text.npos) return std::nullopt;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
  if (error != std::errc()) return std::nullopt;
  text = trimmed({end, text.data() + text.size()});
  return number;
}

}  // namespace

bool isOneOf(std::string_view value, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, value) != words.end();
}

std::optional<double> metresOf(std::string_view value) {
  constexpr double kFoot = 0.3048;  // m
  static const std::map<std::string_view, double> kUnits = {
      {"", 1},       {"m", 1},      {"km", 1000}, {"cm", 0.01},       {"mi", 1609.344},
      {"nmi", 1852}, {"ft", kFoot}, {"'", kFoot}, {"in", kFoot / 12}, {"\"", kFoot / 12}};
  const std::optional<double> number = takeNumber(value);
  if (!number) return std::nullopt;
  if (const auto unit = kUnits.find(value); unit != kUnits.end()) return unit->second * *number;
  if (!value.starts_with("'")) return std::nullopt;
  value.remove_prefix(1);
  const std::optional<double> inches = takeNumber(value);
  return inches && value == "\"" ? std::optional(kFoot * (*number + *inches / 12)) : std::nullopt;
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

void TagNumbers::report(LeftOut& leftOut) const {
  for (const auto& [key, unusable] : unusable_) {
    leftOut.add(fmt::format("values of {} that cannot be used, such as {}", key, unusable.example), unusable.count);
  }
}

}  // namespace scanmill::town
