#pragma once

// Values of OpenStreetMap's tags.

#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/format_support.h"
#include "town/osm.h"

namespace scanmill::town {

bool isOneOf(std::string_view value, std::initializer_list<std::string_view> words);

// Returns the length (m) that a tag's value gives by OpenStreetMap's rules, such as "12", "12.5 m", "40 ft", "40'6\""
// and "0.2 km"; nullopt for other values. A comma before one or two digits is taken as a decimal point.
std::optional<double> metresOf(std::string_view value);
// Returns the value of a plain number; nullopt for other values.
std::optional<double> numberOf(std::string_view value);
// Returns the direction (degrees clockwise from north) of "90" or "ESE"; nullopt for other values.
std::optional<double> compassOf(std::string_view value);

// Reads the tags whose values are numbers, and counts the values that cannot be used.
class TagNumbers {
 public:
  using Parse = std::optional<double> (*)(std::string_view value);
  // Returns the value of a tag; nullopt if there is no such tag, or if its value cannot be parsed or is not from
  // `least` to `most`, which is counted.
  std::optional<double> read(const OsmTags& tags, const char* key, Parse parse, double least, double most);
  // Adds what was counted, with an example of each key.
  void tell(LeftOut& leftOut) const;

 private:
  struct Unusable {
    std::uint64_t count = 0;
    std::string example;
  };
  std::map<std::string, Unusable> unusable_;
};

}  // namespace scanmill::town
