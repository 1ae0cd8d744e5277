#pragma once

// The part of an OpenStreetMap extract that a town needs.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace scanmill::town {

struct OsmTags {
  std::vector<std::pair<std::string, std::string>> pairs;

  // Returns the value of a tag; empty if there is no such tag.
  const std::string& operator[](const char* key) const {
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
  std::vector<OsmNode> nodes;  // nodes that are missing in the extract are left out
};

// A part of a closed way or of a multipolygon relation: one outer ring with its inner rings. The first node of a ring
// is not repeated at its end; outer rings are counter-clockwise, inner rings clockwise.
struct OsmArea {
  OsmTags tags;
  std::vector<OsmNode> outer;
  std::vector<std::vector<OsmNode>> inner;
};

struct OsmExtract {
  std::vector<OsmPoint> points;  // nodes with tags
  std::vector<OsmWay> ways;      // ways with the key highway or barrier
  // Areas with the key building, landuse, leisure, natural or amenity, and areas with the key highway and `area: yes`.
  std::vector<OsmArea> areas;
};

}  // namespace scanmill::town
