#pragma once

// Turns an asset into meshes of a scene. Rules give its parts their classes, materials and object numbers.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "scene/builder.h"
#include "scenefile/rules.h"
#include "scenefile/things.h"

namespace scanmill {

struct Labelling {
  std::vector<Rule> rules;  // the first rule that matches decides
  std::string file;  // the asset's path as the scene file writes it; the key `file` of a rule is compared with it
  ThingBounds things = {};  // how triangles of thing classes are divided into things
  bool counted = false;     // true if an earlier moment of the same clip has already counted the dropped and unlabelled
                            // triangles
  bool operator==(const Labelling&) const = default;
};

// Returns true if the texture of some part is used: a rule tests its colours, or no rule gives the complete part a
// material without texture.
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

}  // namespace scanmill
