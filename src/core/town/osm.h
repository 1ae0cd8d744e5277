#pragma once

// The part of an OpenStreetMap extract that a town needs.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

// A way, or a part of it: nodes that are missing in the extract divide a way into parts.
struct OsmWay {
  OsmTags tags;
  std::vector<OsmNode> nodes;
  bool area = false;        // true: the way is a closed outline, and its tags may be those of an area
  bool incomplete = false;  // true for one part of each way with missing nodes, which may have no nodes
};

// A part of a closed way or of a multipolygon relation: one outer ring with its inner rings. The first node of a ring
// is not repeated at its end; outer rings are counter-clockwise, inner rings clockwise.
struct OsmArea {
  OsmTags tags;
  std::vector<OsmNode> outer;
  std::vector<std::vector<OsmNode>> inner;
  std::string fault;  // why the area has no rings, such as "missing nodes"; empty: it has rings
  // Areas with the same id are one building: the id of the relation with `type: building` that has the area as a
  // member, or else of the multipolygon, if it has several outer rings; 0: neither.
  std::int64_t building = 0;
};

struct OsmExtract {
  std::vector<OsmPoint> points;  // nodes with tags
  std::vector<OsmWay> ways;      // ways with one of kMappedKeys that are no areas, or have the key barrier
  // Closed ways with the keys building, building:part, landuse, landcover, leisure, natural and amenity, with `area:
  // yes` and the keys highway, aeroway or barrier, and with some values of aeroway and waterway; multipolygons with any
  // of the keys.
  std::vector<OsmArea> areas;
  std::map<std::string, std::uint64_t> leftOut;  // numbers of elements that were left out, by what they are
};

}  // namespace scanmill::town
