#pragma once

// Places the nodes of a glTF file, at a time of an animation (glTF 2.0, 3.11).

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/gltf/data.h"
#include "assets/meshes/gltf/model.h"
#include "base/vec.h"

namespace scanmill::gltf {

// Returns the name of an animation, or its number if it has no name.
std::string nameOf(const Model& model, Index animation);

// Returns the index of the animation that `name` names or, if there is none, whose number (from 0) `name` is. If
// neither exists, throws InputError with a suggestion.
Index animationNamed(const Model& model, const std::string& name);

// Returns the times of an animation's first and last key frame (s); nullopt if it has no key frames.
std::optional<std::pair<double, double>> spanOf(const Model& model, const Data& data, Index animation);

// Sets the animated properties of the model's nodes to the clip's values at its time. Throws InputError if a sampler's
// times are not ascending, or if their number does not fit the values.
void apply(const ClipTime& clip, const Data& data, Model& model);

// Returns the transform from a node to its parent.
Affine localOf(const Node& node);

struct PlacedNode {
  Index node = 0;
  Affine sceneFromNode;
  std::string_view name;  // name of the node or of the nearest ancestor with a name, else of its mesh; refers into the
                          // model
  bool visible = true;
};

// Returns the nodes of the scene with their transforms, in file order, depth first.
std::vector<PlacedNode> placeNodes(const Model& model);

// Returns the transform of a 4 x 4 matrix whose numbers are ordered column by column.
template <class Number>
Affine toAffine(const Number* m) {
  const auto column = [&](std::size_t c) {
    return Vec3d{static_cast<double>(m[4 * c]), static_cast<double>(m[4 * c + 1]), static_cast<double>(m[4 * c + 2])};
  };
  return {{column(0), column(1), column(2)}, column(3)};
}

}  // namespace scanmill::gltf
