#pragma once

// Which triangles of an asset are one thing: the key `instances` of an object.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "config/fields.h"

namespace scanmill {

struct ThingBounds {
  enum class By { Object, Node, Part, Name };
  By by = By::Object;
  std::string pattern;  // of Name: a regular expression with its slashes; nodes of the same match are one thing
  Location where;

  std::string text() const;  // that differs where they differ
};

// Reads `instances: object | node | part | /regular expression/`. Throws InputError with the place.
ThingBounds readThingBounds(Fields& object, ThingBounds::By fallback);

// Triangles of one class of things, as labels have divided them.
struct ThingTriangles {
  const AssetPart* part = nullptr;
  std::uint16_t semantic = 0;
};

// By these triangles: of each the number of its thing, from 1; one number, in the order of the nodes or of the
// triangles, for all that is one thing.
//
//   Object  all is one.
//   Node    the triangles of each node are one; nodes are numbered by AssetPart::nodeIndex.
//   Name    the triangles of all nodes whose names match alike are one: what the first group of the regular expression
//           matches, or where it has none, what it matches as a whole. Other nodes are each one.
//   Part    the triangles of a class that are connected are one, see thingsOf().
std::vector<std::vector<std::uint32_t>> numberThings(const ThingBounds& bounds,
                                                     const std::vector<ThingTriangles>& triangles);

}  // namespace scanmill
