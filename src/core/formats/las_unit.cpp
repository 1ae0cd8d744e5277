// WKT 1: "OpenGIS Implementation Specification: Coordinate Transformation Services", OGC 01-009, 7.2. WKT 2:
// "Geographic information - Well-known text representation of coordinate reference systems", OGC 18-010r11. Keys: "OGC
// GeoTIFF Standard", OGC 19-008r4, 7; codes of units are EPSG's.

#include "formats/las_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

namespace scanmill {

namespace {

// KEYWORD[child, child, ...], or a value without children.
struct Wkt {
  std::string_view text;
  std::vector<Wkt> children{};

  bool is(std::initializer_list<std::string_view> keywords) const {
    return !children.empty() && std::find(keywords.begin(), keywords.end(), text) != keywords.end();
  }
};

class WktReader {
 public:
  explicit WktReader(std::string_view text) : text_(text) {}

  // Reads as far as the text is well-formed.
  Wkt read(int depth = 0) {
    constexpr int kDeepest = 30;
    Wkt node{token()};
    if (depth == kDeepest || !skip("[(")) return node;
    do {
      node.children.push_back(read(depth + 1));
    } while (skip(","));
    skip("])");
    return node;
  }

 private:
  std::string_view token() {
    constexpr std::string_view kBlanks = " \t\r\n";
    text_.remove_prefix(std::min(text_.find_first_not_of(kBlanks), text_.size()));
    const bool quoted = text_.starts_with('"');
    if (quoted) text_.remove_prefix(1);
    const std::string_view found = text_.substr(0, text_.find_first_of(quoted ? "\"" : ",[]() \t\r\n"));
    text_.remove_prefix(std::min(found.size() + (quoted ? 1u : 0u), text_.size()));
    return found;
  }

  bool skip(std::string_view any) {
    text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n"), text_.size()));
    if (text_.empty() || any.find(text_.front()) == std::string_view::npos) return false;
    text_.remove_prefix(1);
    return true;
  }

  std::string_view text_;
};

// Returns the unit of length of a coordinate system: its own, or else that of its first axis that has one.
std::pair<double, std::string> unitOf(const Wkt& system) {
  for (const Wkt& child : system.children) {
    if (!child.is({"UNIT", "LENGTHUNIT"}) || child.children.size() < 2) continue;
    const std::string_view size = child.children[1].text;
    double metres = 0;
    std::from_chars(size.data(), size.data() + size.size(), metres);
    return {metres, std::string(child.children[0].text)};
  }
  for (const Wkt& child : system.children) {
    if (!child.is({"AXIS"})) continue;
    if (auto unit = unitOf(child); unit.first > 0) return unit;
  }
  return {0, ""};
}

void addUnit(const Wkt& system, LasUnit& unit) {
  const bool ellipsoidal = std::any_of(system.children.begin(), system.children.end(), [](const Wkt& child) {
    return child.is({"CS"}) && child.children.front().text == "ellipsoidal";
  });
  if (system.is({"COMPD_CS", "COMPOUNDCRS", "BOUNDCRS", "SOURCECRS"})) {
    for (const Wkt& child : system.children) addUnit(child, unit);
  } else if (system.is({"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"}) || ellipsoidal) {
    unit.degrees = true;
  } else if (system.is({"VERT_CS", "VERTCRS", "VERTICALCRS"})) {
    if (const auto [metres, name] = unitOf(system); metres > 0) unit.vertical = metres;
  } else if (system.is({"PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS", "GEOCCS",
                        "GEODCRS", "GEODETICCRS"})) {
    if (auto [metres, name] = unitOf(system); metres > 0) {
      unit.horizontal = metres;
      unit.name = std::move(name);
    }
  }
}

}  // namespace

LasUnit unitOfWkt(std::string_view text) {
  LasUnit unit;
  constexpr std::size_t kLongest = 1 << 20;  // bytes of a text that is read
  addUnit(WktReader(text.substr(0, kLongest)).read(), unit);
  return unit;
}

LasUnit unitOfGeoKeys(std::string_view directory, std::string_view numbers) {
  constexpr std::uint16_t kModel = 1024, kGeographic = 2, kSystem = 3072, kUnit = 3076, kUnitSize = 3077,
                          kVerticalSystem = 4096, kVerticalUnit = 4099, kUserDefined = 32767, kDoubles = 34736;
  constexpr std::uint16_t kFoot = 9002, kSurveyFoot = 9003;
  static const std::map<int, std::pair<double, const char*>> kUnits{
      {9001, {1, "metre"}}, {kFoot, {0.3048, "foot"}}, {kSurveyFoot, {1200.0 / 3937, "US survey foot"}}};
  // Units of systems of heights: NGVD29 and NAVD88 in feet.
  static const std::map<int, std::uint16_t> kHeights{{5702, kSurveyFoot}, {6360, kSurveyFoot}, {8228, kFoot}};
  std::map<int, std::uint16_t> keys;
  double userSize = 0;
  constexpr std::size_t kEntry = 8;  // bytes: key, where its value is, count, value or index
  for (std::size_t at = kEntry; at + kEntry <= directory.size(); at += kEntry) {
    std::uint16_t entry[4];
    std::memcpy(entry, directory.data() + at, kEntry);
    const std::size_t number = std::size_t{entry[3]} * sizeof(double);
    if (entry[1] == 0) {
      keys[entry[0]] = entry[3];
    } else if (entry[0] == kUnitSize && entry[1] == kDoubles && number + sizeof(double) <= numbers.size()) {
      std::memcpy(&userSize, numbers.data() + number, sizeof(double));
    }
  }
  LasUnit unit;
  unit.degrees = keys[kModel] == kGeographic;
  const int system = keys[kSystem];
  if (const auto found = kUnits.find(keys[kUnit]); found != kUnits.end()) {
    unit.horizontal = found->second.first;
    unit.name = found->second.second;
  } else if (keys[kUnit] == kUserDefined && userSize > 0) {
    unit.horizontal = userSize;
    unit.name = "unit of its own";
  } else if (keys[kUnit] != 0) {
    unit.unknown = keys[kUnit];
  } else if (system != 0 && system != kUserDefined) {
    // Systems of UTM, whose codes lie in these ranges, are in metres.
    const auto within = [&](int low, int high) { return system >= low && system <= high; };
    const bool isUtm = within(32601, 32760) || within(25828, 25838) || within(26901, 26923);
    unit.unstated = isUtm ? 0 : system;
  }
  const auto heights = kHeights.find(keys[kVerticalSystem]);
  const int vertical = keys[kVerticalUnit] == 0 && heights != kHeights.end() ? heights->second : keys[kVerticalUnit];
  if (const auto found = kUnits.find(vertical); found != kUnits.end()) {
    unit.vertical = found->second.first;
  } else if (vertical != 0) {
    unit.unknown = vertical;
  }
  return unit;
}

}  // namespace scanmill
