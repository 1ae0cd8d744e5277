#pragma once

// Divides the triangles of an asset into things (object instances): the key `instances` of an object.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "config/fields.h"

namespace scanmill {

struct ThingBounds {
  enum class By { Object, Node, Part, Name };
  By by = By::Object;
  std::string pattern;  // only for By::Name: a regular expression between slashes; all nodes with the same match are
                        // one thing
  Location where;
  bool byClass = false;  // true: triangles of different classes are different things (point clouds)

  // Compares all but the place in the file.
  bool operator==(const ThingBounds& o) const { return by == o.by && pattern == o.pattern && byClass == o.byClass; }
};

// Reads `instances: object | node | part | /regular expression/`. Throws InputError with the place.
ThingBounds readThingBounds(Fields& object, ThingBounds::By fallback);

// An asset part whose triangles all have the same thing class.
struct ThingTriangles {
  const AssetPart* part = nullptr;
  std::uint16_t semantic = 0;
};

// Returns, by part and triangle, the number of the triangle's thing, from 1. Things are numbered in the order of their
// nodes, or, with Part, of their triangles.
//
//   Object  All triangles are one thing.
//   Node    Each node is one thing; nodes are numbered by AssetPart::nodeIndex.
//   Name    All nodes with the same match are one thing. The match is the text of the regular expression's first group,
//           or the complete match if the expression has no group. Each node without a match is one thing.
//   Part    Triangles of one class are grouped into things by thingsOf().
//
// With ThingBounds::byClass each class of a node or of a match has things of its own.
std::vector<std::vector<std::uint32_t>> numberThings(const ThingBounds& bounds,
                                                     const std::vector<ThingTriangles>& triangles);

}  // namespace scanmill
