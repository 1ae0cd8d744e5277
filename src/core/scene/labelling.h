#pragma once

// An asset becomes a mesh of a scene: its parts get classes, materials and instance numbers from rules.

#include <cstdint>
#include <string>
#include <vector>

#include "scene/assets/asset.h"
#include "scene/builder.h"
#include "scene/rules.h"

namespace scanmill {

struct Labelling {
  std::vector<Rule> rules;  // first match wins
  std::string file;         // as the scene names it: what `file` patterns see
  bool perNode = false;     // each node with a thing class is a thing (true), or the whole asset is one (false)
};

// Whether some part shows its base colour: it has a texture, and no rule's material that does without.
bool showsTextures(const SceneBuilder& builder, const Asset& asset, const Labelling& labelling);

// Merges the parts into one mesh, adds it to the scene and returns its index. Triangles without a class get class 0 and
// are counted as unlabelled; a part without a rule's material keeps its own look. InputError at `where` for a class or
// material that nobody knows, and for an asset without a triangle that can be traced.
std::uint32_t addAsset(SceneBuilder& builder, Asset asset, const Labelling& labelling, const Location& where);

}  // namespace scanmill
