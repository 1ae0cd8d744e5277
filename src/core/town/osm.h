#pragma once

// The part of an OpenStreetMap extract that a town needs, its tags, and the module that reads it with libosmium.

#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/format_support.h"
#include "base/module.h"

namespace scanmill::town {

// Keys of elements, besides buildings, that the town builds or counts.
inline constexpr const char* kMappedKeys[] = {
    "highway",   "barrier",   "railway",      "waterway",         "power",           "man_made",    "natural",
    "landuse",   "leisure",   "amenity",      "parking",          "historic",        "advertising", "traffic_sign",
    "aerialway", "aeroway",   "area:highway", "public_transport", "traffic_calming", "military",    "golf",
    "tourism",   "emergency", "place",        "landcover"};

struct OsmTags {
  std::string element;  // the element that has the tags: "way 12"
  std::vector<std::pair<std::string, std::string>> pairs;

  // Returns the value of a tag; empty if there is no such tag.
  const std::string& operator[](std::string_view key) const {
    static const std::string none;
    for (const auto& [k, v] : pairs) {
      if (k == key) return v;
    }
    return none;
  }
};

struct OsmNode {
  std::int64_t id = 0;
  double latitude = 0, longitude = 0;  // degrees, WGS 84
};

struct OsmPoint {
  OsmNode node;
  OsmTags tags;
};

struct OsmWay {
  OsmTags tags;
  std::vector<std::vector<OsmNode>> runs;  // successive nodes; a node that the extract lacks ends a run
  bool area = false;                       // true: the way is a closed outline, and its tags may describe an area
  bool incomplete = false;                 // true: the extract lacks some of the way's nodes
};

// A part of a closed way or of a multipolygon relation: one outer ring with its inner rings. The first node of a ring
// is not repeated at its end; outer rings are counter-clockwise, inner rings clockwise.
struct OsmArea {
  OsmTags tags;
  std::vector<OsmNode> outer;
  std::vector<std::vector<OsmNode>> inner;
  std::string fault;  // why the area has no rings, such as "missing nodes"; empty: it has rings
  // Areas with the same id, if it is not 0, are one building. The id is that of the relation of `type: building` to
  // which the area belongs; without such a relation, that of a multipolygon with several outer rings; otherwise 0.
  std::int64_t building = 0;
};

struct OsmExtract {
  std::vector<OsmPoint> points;  // nodes with tags
  std::vector<OsmWay> ways;      // lines with one of kMappedKeys; areas only with the key barrier or highway
  // Multipolygons with a building key or one of kMappedKeys, and closed ways that are areas by their tags: building,
  // building:part, landuse, landcover, leisure, natural or amenity; highway, aeroway or barrier together with `area:
  // yes`; or some values of aeroway and waterway.
  std::vector<OsmArea> areas;
  std::map<std::string, std::uint64_t> leftOut;  // numbers of elements left out, by a description of the kind
};

class OsmModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_town.so", "OpenStreetMap files cannot be read",
                                    "install bzip2's, expat's and lz4's libraries (on Debian the packages libbz2-1.0, "
                                    "libexpat1 and liblz4-1)"};

  virtual ~OsmModule() = default;
  // Reads a file that is sorted: nodes, ways, relations, each by id. Throws std::exception that names the fault.
  virtual OsmExtract read(const std::string& file) const = 0;
};

bool isOneOf(std::string_view value, std::initializer_list<std::string_view> words);

// Returns the length (m) that a tag's value gives by OpenStreetMap's rules, such as "12", "12.5 m", "40 ft", "40'6\""
// and "0.2 km"; nullopt for other values. A comma before one or two digits is taken as a decimal point.
std::optional<double> metresOf(std::string_view value);
// Returns the number that the value consists of, without a unit; nullopt for other values.
std::optional<double> numberOf(std::string_view value);
// Returns the direction (degrees clockwise from north) of a value such as "90" or "ESE"; nullopt for other values.
std::optional<double> compassOf(std::string_view value);

// Reads the tags whose values are numbers, and counts the values that cannot be used.
class TagNumbers {
 public:
  using Parse = std::optional<double> (*)(std::string_view value);
  // Returns a tag's value; nullopt if the tag is missing or its value is unreadable or outside [least, most].
  std::optional<double> read(const OsmTags& tags, const char* key, Parse parse, double least, double most);
  // Adds the number of unusable values of each key to `leftOut`, with an example.
  void report(LeftOut& leftOut) const;

 private:
  struct Unusable {
    std::uint64_t count = 0;
    std::string example;
  };
  std::map<std::string, Unusable> unusable_;
};

}  // namespace scanmill::town
