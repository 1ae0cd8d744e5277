#pragma once

// Poses a glTF file at a time of an animation: its nodes, skins and morph targets (glTF 2.0, 3.7.2.2, 3.7.3 and 3.11).

#include <functional>
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

// Returns the index of the animation with this name; if there is none, `name` may be an animation's number. Otherwise
// throws InputError with a suggestion.
Index animationNamed(const Model& model, const std::string& name);

// Returns the times of an animation's first and last key frame (s); nullopt if it has no key frames.
std::optional<std::pair<double, double>> spanOf(const Model& model, const Data& data, Index animation);

// Sets the nodes of the model to the values that the clip has at its time. Throws InputError if a sampler's times are
// not ascending or their number does not fit the values.
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

// Returns the nodes of the scene in file order, depth first.
std::vector<PlacedNode> placeNodes(const Model& model);

// Returns points of three numbers each.
std::vector<Vec3d> toPoints(const std::vector<float>& numbers);

// A function that returns all numbers of a primitive's attribute `name`, vertex by vertex; empty if the primitive lacks
// the attribute.
using AttributeNumbers = std::function<std::vector<float>(const std::string& name)>;

// Applies morph targets and skins to the vertices of primitives.
class Poser {
 public:
  // The arguments must outlive the object.
  Poser(const Model& model, const Data& data, const std::vector<PlacedNode>& placed);

  // True if neither a skin nor morph targets change the vertices of a node's mesh.
  bool isRigid(const PlacedNode& node) const;

  // Poses `points`, the vertices of a primitive of the node's mesh, given in the mesh's frame. The results are in the
  // scene's frame if the node has a skin, else in the mesh's frame. `what` is the mesh's name in messages. Throws
  // InputError if joints, weights or targets do not fit the vertices.
  void pose(const PlacedNode& node, const Primitive& primitive, const AttributeNumbers& numbers,
            const std::string& what, std::vector<Vec3d>& points);

 private:
  // Returns the weights of a node's morph targets; empty if all are 0.
  std::vector<double> weightsOf(const PlacedNode& placed) const;
  std::vector<Affine> jointsOf(const Skin& skin, const std::string& what) const;
  void skin(const PlacedNode& node, const AttributeNumbers& numbers, const std::string& what,
            std::vector<Vec3d>& points) const;

  const Model& model_;
  const Data& data_;
  std::vector<const PlacedNode*> placedNodes_;  // by node; null for nodes that are not in the scene
};

}  // namespace scanmill::gltf
