// WKT 1: "OpenGIS Implementation Specification: Coordinate Transformation Services", OGC 01-009, 7.2. WKT 2:
// "Geographic information - Well-known text representation of coordinate reference systems", OGC 18-010r11. Keys: "OGC
// GeoTIFF Standard", OGC 19-008r4, 7; codes of units are EPSG's.

#include "rasters/system_unit.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <utility>
#include <vector>

#include "config/text.h"

namespace scanmill {

namespace {

// KEYWORD[child, child, ...], or a value without children.
struct Wkt {
  std::string_view text;
  std::vector<Wkt> children{};

  bool is(std::initializer_list<std::string_view> keywords) const {
    const auto same = [&](std::string_view keyword) {
      return std::equal(keyword.begin(), keyword.end(), text.begin(), text.end(),
                        [](char a, char b) { return a == std::toupper(static_cast<unsigned char>(b)); });
    };
    return !children.empty() && std::any_of(keywords.begin(), keywords.end(), same);
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

  // Skips one of the characters. Returns false if another one follows.
  bool skip(std::string_view any) {
    text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n"), text_.size()));
    if (text_.empty() || any.find(text_.front()) == std::string_view::npos) return false;
    text_.remove_prefix(1);
    return true;
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

// True if the node, or one inside of it, has one of the keywords and a first value that begins with one of the texts.
bool states(const Wkt& node, std::initializer_list<std::string_view> keywords,
            std::initializer_list<std::string_view> texts) {
  const auto begins = [&](std::string_view text) { return node.children.front().text.starts_with(text); };
  return (node.is(keywords) && std::any_of(texts.begin(), texts.end(), begins)) ||
         std::any_of(node.children.begin(), node.children.end(),
                     [&](const Wkt& child) { return states(child, keywords, texts); });
}

// Returns false if the node is no coordinate system that is known.
bool addUnit(const Wkt& system, SystemUnit& unit) {
  const bool ellipsoidal = std::any_of(system.children.begin(), system.children.end(), [](const Wkt& child) {
    return child.is({"CS"}) && child.children.front().text == "ellipsoidal";
  });
  bool known = false;
  if (system.is({"COMPD_CS", "COMPOUNDCRS", "BOUNDCRS", "SOURCECRS", "DERIVEDPROJCRS"})) {
    for (const Wkt& child : system.children) known = addUnit(child, unit) || known;
  }
  if (system.is({"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"}) || ellipsoidal) {
    unit.degrees = true;
  } else if (system.is({"VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"})) {
    const bool down = std::any_of(system.children.begin(), system.children.end(), [](const Wkt& child) {
      if (child.children.size() < 2) return false;
      const std::string_view value = child.children[1].text;
      // Esri states directions by a parameter.
      return child.is({"AXIS"}) ? value == "DOWN" || value == "down"
                                : child.children[0].text == "Direction" && value.starts_with('-');
    });
    if (const auto [metres, name] = unitOf(system); metres > 0) unit.vertical = down ? -metres : metres;
  } else if (system.is({"GEOCCS", "GEODCRS", "GEODETICCRS"})) {
    unit.geocentric = true;
  } else if (system.is({"PROJCS", "PROJCRS", "PROJECTEDCRS", "BASEPROJCRS", "DERIVEDPROJCRS", "LOCAL_CS", "ENGCRS",
                        "ENGINEERINGCRS"})) {
    unit.mercator = unit.mercator || states(system, {"PROJECTION", "METHOD"},
                                            {"Mercator_1SP", "Mercator_Aux", "Mercator (variant A)", "Popular"});
    std::string axes;  // the first letters of their directions
    for (const Wkt& child : system.children) {
      const bool directed = child.is({"AXIS"}) && child.children.size() > 1 && !child.children[1].text.empty();
      if (directed) axes += lowerCase(child.children[1].text.substr(0, 1));
    }
    unit.mirrored = axes == "sw" || axes == "es" || axes == "wn";
    if (auto [metres, name] = unitOf(system); metres > 0) {
      unit.horizontal = metres;
      unit.name = std::move(name);
    }
  } else {
    return known;
  }
  return true;
}

// The first directory of a TIFF ("TIFF", revision 6.0, Adobe 1992, 2) or of a BigTIFF, whose offsets and counts have 8
// bytes.
class TiffTags {
 public:
  explicit TiffTags(const std::filesystem::path& file) : in_(file, std::ios::binary) {
    swapped_ = (number<std::uint16_t>(0) & 0xFF) == 'M';
    big_ = number<std::uint16_t>(2) == 43;
  }

  // Returns the bytes of a tag's values in this machine's order; empty if the file has no such tag.
  template <class T>
  std::string values(std::uint16_t tag) {
    constexpr std::uint64_t kMost = 1 << 20;
    const std::uint64_t first = offset(big_ ? 8 : 4);
    const std::uint64_t count = big_ ? offset(first) : number<std::uint16_t>(first);
    for (std::uint64_t i = 0; in_ && i < std::min(count, kMost); ++i) {
      const std::uint64_t entry = first + (big_ ? 8 + 20 * i : 2 + 12 * i);
      if (number<std::uint16_t>(entry) != tag) continue;
      const std::uint64_t many = std::min(offset(entry + 4), kMost), own = entry + (big_ ? 12 : 8);
      const std::uint64_t at = many * sizeof(T) <= (big_ ? 8 : 4) ? own : offset(own);
      std::string bytes(many * sizeof(T), '\0');
      in_.seekg(static_cast<std::streamoff>(at)).read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      for (std::size_t k = 0; swapped_ && k < bytes.size(); k += sizeof(T)) {
        std::reverse(bytes.data() + k, bytes.data() + k + sizeof(T));
      }
      return in_ ? bytes : "";
    }
    return "";
  }

 private:
  std::uint64_t offset(std::uint64_t at) { return big_ ? number<std::uint64_t>(at) : number<std::uint32_t>(at); }

  template <class T>
  T number(std::uint64_t at) {
    char bytes[sizeof(T)] = {};
    in_.seekg(static_cast<std::streamoff>(at)).read(bytes, sizeof(T));
    if (swapped_) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

  std::ifstream in_;
  bool swapped_ = false, big_ = false;
};

}  // namespace

SystemUnit unitOfWkt(std::string_view text) {
  SystemUnit unit;
  constexpr std::size_t kLongest = 1 << 20;                     // bytes of a text that is read
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // the mark of UTF-8
  WktReader reader(text.substr(0, kLongest));
  bool known = false;
  do {
    known = addUnit(reader.read(), unit) || known;
  } while (reader.skip(","));  // Esri's text has the vertical system behind the other one
  unit.unread = !known || (unit.name.empty() && !unit.degrees && !unit.geocentric);
  return unit;
}

SystemUnit unitOfGeoKeys(std::string_view directory, std::string_view numbers, std::string_view texts) {
  constexpr std::uint16_t kModel = 1024, kGeographic = 2, kSystem = 3072, kUnit = 3076, kUnitSize = 3077,
                          kVerticalSystem = 4096, kVerticalCitation = 4097, kVerticalUnit = 4099, kUserDefined = 32767,
                          kDoubles = 34736, kTexts = 34737;
  constexpr std::uint16_t kGeocentric = 3, kDegrees = 2048, kProjection = 3075, kMercator = 7;
  constexpr std::uint16_t kMetre = 9001, kFoot = 9002, kSurveyFoot = 9003;
  static const std::map<int, std::pair<double, const char*>> kUnits{
      {kMetre, {1, "metre"}}, {kFoot, {0.3048, "foot"}}, {kSurveyFoot, {1200.0 / 3937, "US survey foot"}}};
  // Units of EPSG's systems of heights in feet, and of all its systems of depths.
  static const std::map<int, std::uint16_t> kHeights{{5702, kSurveyFoot}, {6360, kSurveyFoot}, {8052, kSurveyFoot},
                                                     {6130, kFoot},       {6131, kFoot},       {6132, kFoot},
                                                     {8050, kFoot},       {8228, kFoot}};
  static const std::map<int, std::uint16_t> kDepths{
      {5336, kMetre}, {5612, kMetre},      {5614, kFoot},       {5706, kMetre}, {5715, kMetre},      {5734, kMetre},
      {5739, kMetre}, {5789, kMetre},      {5831, kMetre},      {5861, kMetre}, {5862, kMetre},      {5863, kMetre},
      {5864, kMetre}, {5865, kMetre},      {5866, kMetre},      {5867, kMetre}, {5873, kMetre},      {6357, kMetre},
      {7976, kMetre}, {6358, kSurveyFoot}, {6359, kSurveyFoot}, {8051, kFoot},  {8053, kSurveyFoot}, {8358, kMetre},
      {9287, kMetre}, {9288, kMetre},      {9672, kMetre}};
  std::map<int, std::uint16_t> keys;
  double userSize = 0;
  std::string citation;              // of the vertical system, in lower case
  constexpr std::size_t kEntry = 8;  // bytes: key, where its value is, count, value or index
  for (std::size_t at = kEntry; at + kEntry <= directory.size(); at += kEntry) {
    std::uint16_t entry[4];
    std::memcpy(entry, directory.data() + at, kEntry);
    const std::size_t number = std::size_t{entry[3]} * sizeof(double);
    if (entry[1] == 0) {
      keys[entry[0]] = entry[3];
    } else if (entry[0] == kUnitSize && entry[1] == kDoubles && number + sizeof(double) <= numbers.size()) {
      std::memcpy(&userSize, numbers.data() + number, sizeof(double));
    } else if (entry[0] == kVerticalCitation && entry[1] == kTexts && entry[3] < texts.size()) {
      citation = lowerCase(texts.substr(entry[3], entry[2]));
    }
  }
  SystemUnit unit;
  const int system = keys[kSystem];
  unit.degrees = keys[kModel] == kGeographic || (keys[kModel] == 0 && keys[kDegrees] != 0 && system == 0);
  unit.geocentric = keys[kModel] == kGeocentric;
  unit.code = system == kUserDefined ? 0 : system;
  unit.mercator = keys[kProjection] == kMercator || system == 3857 || system == 3785 || system == 3395 ||
                  system == 3832 || system == 3752 || system == 54004;
  if (const auto found = kUnits.find(keys[kUnit]); found != kUnits.end()) {
    unit.horizontal = found->second.first;
    unit.name = found->second.second;
  } else if (keys[kUnit] == kUserDefined && userSize > 0) {
    unit.horizontal = userSize;
    unit.name = "unit of its own";
  } else if (keys[kUnit] != 0) {
    unit.unknown = keys[kUnit];
  } else if (unit.code != 0 && !unit.mercator) {
    // Systems of UTM, whose codes lie in these ranges, are in metres.
    const auto within = [&](int low, int high) { return system >= low && system <= high; };
    const bool isUtm = within(32601, 32760) || within(25828, 25838) || within(26901, 26923);
    unit.unstated = isUtm ? 0 : system;
  }
  const auto depths = kDepths.find(keys[kVerticalSystem]);
  const bool down = depths != kDepths.end();
  const auto heights = kHeights.find(keys[kVerticalSystem]);
  int vertical = keys[kVerticalUnit];
  if (vertical == 0 && (down || heights != kHeights.end())) vertical = down ? depths->second : heights->second;
  const auto cites = [&](std::initializer_list<const char*> words) {
    return std::any_of(words.begin(), words.end(), [&](const char* w) { return citation.find(w) != citation.npos; });
  };
  if (vertical == 0 && cites({"(ft", " ft", "feet", "foot"})) vertical = cites({"us", "survey"}) ? kSurveyFoot : kFoot;
  if (vertical == 0 && cites({"(m)", "metre", "meter"})) vertical = kMetre;
  if (const auto found = kUnits.find(vertical); found != kUnits.end()) {
    unit.vertical = found->second.first * (down ? -1 : 1);
  } else if (vertical != 0) {
    unit.unknown = vertical;
  }
  return unit;
}

SystemUnit unitOfTiff(const std::filesystem::path& file) {
  TiffTags tags(file);
  const std::string directory = tags.values<std::uint16_t>(34735);
  SystemUnit unit = unitOfGeoKeys(directory, tags.values<double>(34736), tags.values<char>(34737));
  // GDAL stores the unit that a user states in texts of its own.
  if (tags.values<char>(42112).find("unittype") != std::string::npos) unit.vertical.reset();
  return unit;
}

}  // namespace scanmill
