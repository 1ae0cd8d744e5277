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
  std::vector<Rule> rules;  // first match wins
  std::string file;         // as the scene names it; patterns of `file` are compared with it
  ThingBounds things = {};  // how triangles of thing classes are divided into things
  bool counted = false;     // dropped and unlabelled triangles are already counted, with another moment of the clip
};

// True if the base colour of some part has an effect: the part has a texture, and no rule gives the part a material
// that is not textured.
bool showsTextures(const SceneBuilder& builder, const Asset& asset, const Labelling& labelling);

// A mesh of an asset and its poses in the asset's frame; without poses it is placed once, untransformed.
struct PlacedMesh {
  std::uint32_t mesh = 0;
  std::string node;  // name of its first part's node
  std::vector<Affine> assetFromMesh;
};

// Merges the parts into one mesh, and those of each of Asset::instanced into another, and adds them to the scene.
// Triangles that neither a rule nor the file gives a class get class 0 and are counted as unlabelled. A part that no
// rule gives a material keeps that of its file. Throws InputError for an unknown class or material, at its rule, and at
// `where` for an asset without a triangle that can be traced.
std::vector<PlacedMesh> addAsset(SceneBuilder& builder, Asset asset, const Labelling& labelling, const Location& where);

}  // namespace scanmill
