#pragma once

// Makes an asset meshes of a scene. Rules give its parts their classes, materials and object numbers.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "scene/builder.h"
#include "scenefile/rules.h"
#include "scenefile/things.h"

namespace scanmill {

struct Labelling {
  std::vector<Rule> rules;  // first match wins
  std::string file;         // as the scene names it; patterns of `file` are compared with it
  ThingBounds things = {};  // which of what has a thing class is one
  bool counted = false;     // what it drops or leaves unlabelled has been counted, of another moment of it
};

// Whether the base colour of some part is looked at: the part has a texture, and no rule gives it a material that is
// not textured.
bool showsTextures(const SceneBuilder& builder, const Asset& asset, const Labelling& labelling);

// A mesh of an asset, and where it stands in the asset's frame; once and as it is where no places are given.
struct PlacedMesh {
  std::uint32_t mesh = 0;
  std::string node;  // of its first part
  std::vector<Affine> assetFromMesh;
};

// Merges the parts into one mesh, and those of each of Asset::instanced into another, and adds them to the scene.
// Triangles that no rule gives a class get class 0 and are counted as unlabelled. A part that no rule gives a material
// keeps the material that its file gives it. Throws an InputError at `where` for an unknown class or material, and for
// an asset without a triangle that can be traced.
std::vector<PlacedMesh> addAsset(SceneBuilder& builder, Asset asset, const Labelling& labelling, const Location& where);

}  // namespace scanmill
