#pragma once

// Where all of a glTF file is at a time of an animation: nodes, skins and morph targets (glTF 2.0, 3.7.2.2, 3.7.3 and
// 3.11).

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/asset.h"
#include "assets/gltf/data.h"
#include "assets/gltf/model.h"
#include "base/vec.h"

namespace scanmill::gltf {

// The name of an animation, its number where it has none.
std::string nameOf(const Model& model, Index animation);

// The index of the animation with this name, or of its number where none has that name. Throws InputError, with a
// suggestion, where there is none.
Index animationNamed(const Model& model, const std::string& name);

// When the first of an animation's key frames is, and when the last (s); nothing where it has none.
std::optional<std::pair<double, double>> spanOf(const Model& model, const Data& data, Index animation);

// Writes what the clip says at its time into the nodes. Throws InputError where its samplers do not fit.
void apply(const ClipTime& clip, const Data& data, Model& model);

// Where a node stands relative to its parent.
Affine localOf(const Node& node);

struct PlacedNode {
  Index node = 0;
  Affine sceneFromNode;
  std::string_view name;  // its own, or that of its nearest ancestor with one; of the model
  bool visible = true;
};

// The nodes of the scene in file order, depth first.
std::vector<PlacedNode> placeNodes(const Model& model);

// All numbers of a primitive's attribute of this name, vertex after vertex; empty where it has none.
using AttributeNumbers = std::function<std::vector<float>(const std::string& name)>;

// Moves the vertices of a primitive to where morph targets and joints have them.
class Poser {
 public:
  // All are kept by reference.
  Poser(const Model& model, const Data& data, const std::vector<PlacedNode>& placed);

  // Whether a node's mesh keeps the vertices of the file.
  bool isRigid(const PlacedNode& node) const;

  // `points` are the vertices of a primitive of the node's mesh in the mesh's frame, and become those in the scene's
  // frame if the node has a skin, else in the mesh's. `what` is the mesh's name in messages. Throws InputError where
  // joints, weights or targets do not fit.
  void pose(const PlacedNode& node, const Primitive& primitive, const AttributeNumbers& numbers,
            const std::string& what, std::vector<Vec3d>& points);

 private:
  std::vector<double> weightsOf(const PlacedNode& node) const;
  std::vector<Affine> jointsOf(const Skin& skin, const std::string& what) const;
  void skin(const PlacedNode& node, const AttributeNumbers& numbers, const std::string& what,
            std::vector<Vec3d>& points) const;

  const Model& model_;
  const Data& data_;
  std::vector<const PlacedNode*> placedOf_;  // by node; null outside the scene
  std::uint64_t posed_ = 0;
};

}  // namespace scanmill::gltf
