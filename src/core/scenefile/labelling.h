#pragma once

// Turns an asset into meshes of a scene. Rules give its parts their classes and materials; the key `instances` of an
// object divides its triangles into things (object instances).

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "config/fields.h"
#include "scene/builder.h"
#include "scenefile/rules.h"

namespace scanmill {

struct ThingBounds {
  enum class By { Object, Node, Part, Name };
  By by = By::Object;
  // Only for By::Name: a regular expression between slashes. All nodes with the same match are one thing.
  std::string pattern{};
  Location where{};
  bool byClass = false;  // true: triangles of different classes are different things (point clouds)

  // Compares everything except `where`.
  bool operator==(const ThingBounds& o) const { return by == o.by && pattern == o.pattern && byClass == o.byClass; }
};

// Reads `instances: object | node | part | /regular expression/`; `fallback` if the key is absent. Throws InputError.
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
//   Part    Triangles of one class are grouped by their connected parts: groupIntoThings() in things.cpp.
//
// With ThingBounds::byClass, triangles of different classes are different things, even in the same node or match.
std::vector<std::vector<std::uint32_t>> numberThings(const ThingBounds& bounds,
                                                     const std::vector<ThingTriangles>& parts);

struct ConnectedParts {
  std::vector<std::vector<std::uint32_t>> numbers;  // by asset part and triangle: number of its connected part
  std::vector<Box> boxes;                           // bounds (m) of the connected parts, by number
};

// Returns the connected parts. Triangles are connected if they have corners at the same position, even in different
// asset parts. Connected parts are numbered from 0 in the order of their first triangles.
ConnectedParts connect(const std::vector<const AssetPart*>& parts);

struct Labelling {
  std::vector<Rule> rules;  // the first rule that matches decides
  std::string file;  // the asset's path as the scene file writes it; the key `file` of a rule is compared with it
  ThingBounds things = {};  // how triangles of thing classes are divided into things
  // True if an earlier moment of the same clip has already counted the dropped and unlabelled triangles.
  bool counted = false;
  bool operator==(const Labelling&) const = default;
};

// Returns true if the texture of some part is used because no rule gives the complete part a material without texture.
// No rule may test colours.
bool showsTextures(const SceneBuilder& builder, const Asset& asset, const Labelling& labelling);

// A mesh of an asset and its poses in the asset's frame. Without poses the mesh is placed once, untransformed.
struct PlacedMesh {
  std::uint32_t mesh = 0;
  std::string node;  // name of the node of the mesh's first part
  std::vector<Affine> assetFromMesh;
};

// Adds an asset to the scene: Asset::parts as one mesh, and each entry of Asset::instanced as a further mesh. Triangles
// without a class, from a rule or from the file, get class 0 and are counted as unlabelled. A part without a material
// from a rule keeps the material of its file. Throws InputError at the rule for an unknown class or material, and at
// `where` for an asset of which no triangle remains.
[[nodiscard]] std::vector<PlacedMesh> addAsset(SceneBuilder& builder, Asset asset, const Labelling& labelling,
                                               const Location& where);

// The frame in which the positions of an asset's parts are given.
struct PartFrame {
  Vec3d origin;       // m, origin of this frame in the asset's frame
  double lowest = 0;  // m, least z of the points of all parts, in this frame
};

class PartTraits {
 public:
  // Keeps a reference to `part`. Computes the sizes of connected parts (see connect()) only if `withSizes` is true,
  // since this is slow.
  PartTraits(const AssetPart& part, const PartFrame& frame, bool withSizes);

  TriangleTraits at(std::size_t triangle) const;

 private:
  Rgb colorAt(const Triangle& triangle) const;

  const AssetPart& part_;
  PartFrame frame_;
  // The longest edge (m) of the box around each triangle's connected part; empty if `withSizes` was false.
  std::vector<double> sizes_;
};

}  // namespace scanmill
