#include "assets/meshes/gltf/pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/fields.h"

namespace scanmill::gltf {
namespace {

// Returns the transform of a 4 x 4 matrix whose numbers are ordered column by column.
template <class Number>
Affine toAffine(const Number* m) {
  const auto column = [&](std::size_t c) {
    return Vec3d{static_cast<double>(m[4 * c]), static_cast<double>(m[4 * c + 1]), static_cast<double>(m[4 * c + 2])};
  };
  return {{column(0), column(1), column(2)}, column(3)};
}

// The key frames of a sampler, and a time between two of them.
class KeyFrames {
 public:
  // `width`: how many numbers a key frame has.
  KeyFrames(const std::vector<float>& times, const std::vector<float>& values, std::size_t width,
            Animation::Interpolation interpolation, double time)
      : values_(values), width_(width), interpolation_(interpolation) {
    const auto later = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), static_cast<float>(time)) -
                                                times.begin());
    before_ = later == 0 ? 0 : later - 1;
    after_ = std::min(later, times.size() - 1);
    span_ = static_cast<double>(times[after_]) - static_cast<double>(times[before_]);
    if (span_ > 0) fraction_ = std::clamp((time - static_cast<double>(times[before_])) / span_, 0.0, 1.0);
  }

  // Returns the interpolated numbers.
  std::vector<double> numbers() const {
    const double t = fraction_, t2 = t * t, t3 = t2 * t;
    std::vector<double> out(width_);
    for (std::size_t i = 0; i < width_; ++i) {
      if (interpolation_ == Animation::Interpolation::Step || before_ == after_) {
        out[i] = at(before_, Value, i);
      } else if (interpolation_ == Animation::Interpolation::CubicSpline) {
        out[i] = (2 * t3 - 3 * t2 + 1) * at(before_, Value, i) +
                 span_ * (t3 - 2 * t2 + t) * at(before_, OutTangent, i) + (3 * t2 - 2 * t3) * at(after_, Value, i) +
                 span_ * (t3 - t2) * at(after_, InTangent, i);
      } else {
        out[i] = at(before_, Value, i) + (at(after_, Value, i) - at(before_, Value, i)) * t;
      }
    }
    return out;
  }

  // Returns the interpolated rotation as a unit quaternion (x, y, z, w).
  std::vector<double> rotation() const {
    std::vector<double> q = numbers();
    if (interpolation_ == Animation::Interpolation::Linear && before_ != after_) {
      const Quat s = slerp(quaternion(before_), quaternion(after_), fraction_);
      q = {s.x, s.y, s.z, s.w};
    }
    const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(size > 0)) return {0, 0, 0, 1};
    for (double& number : q) number /= size;
    return q;
  }

 private:
  enum Part { InTangent, Value, OutTangent };  // of a key frame of a cubic spline (appendix C.5); others have a value

  double at(std::size_t key, Part part, std::size_t i) const {
    const bool cubic = interpolation_ == Animation::Interpolation::CubicSpline;
    return static_cast<double>(values_[cubic ? (3 * key + part) * width_ + i : key * width_ + i]);
  }

  Quat quaternion(std::size_t key) const {
    return {at(key, Value, 3), at(key, Value, 0), at(key, Value, 1), at(key, Value, 2)};
  }

  const std::vector<float>& values_;
  std::size_t width_;
  Animation::Interpolation interpolation_;
  // The key frames around the time; the same one before the first or after the last.
  std::size_t before_ = 0, after_ = 0;
  double span_ = 0;      // s, between them
  double fraction_ = 0;  // of the span
};

}  // namespace

std::vector<Vec3d> toPoints(const std::vector<float>& values) {
  std::vector<Vec3d> points;
  points.reserve(values.size() / 3);
  for (std::size_t i = 0; i + 2 < values.size(); i += 3) {
    points.emplace_back(Vec3f{values[i], values[i + 1], values[i + 2]});
  }
  return points;
}

std::string nameOf(const Model& model, Index animation) {
  const std::string& name = model.animations[animation].name;
  return name.empty() ? std::to_string(animation) : name;
}

Index animationNamed(const Model& model, const std::string& name) {
  std::vector<std::string> names;
  for (Index i = 0; i < model.animations.size(); ++i) names.push_back(nameOf(model, i));
  for (Index i = 0; i < names.size(); ++i) {
    if (names[i] == name) return i;
  }
  for (Index i = 0; i < names.size(); ++i) {
    if (std::to_string(i) == name) return i;
  }
  model.fail(names.empty() ? "has no animation"
                           : fmt::format("has no animation '{}'{}", name, suggestion(name, names)));
}

std::optional<std::pair<double, double>> spanOf(const Model& model, const Data& data, Index animation) {
  double first = std::numeric_limits<double>::infinity();
  double last = 0;
  const std::string what = fmt::format("animations[{}]", animation);
  for (const Animation::Sampler& sampler : model.animations[animation].samplers) {
    for (const float time : data.finiteFloats(sampler.input, what)) {
      first = std::min(first, static_cast<double>(time));
      last = std::max(last, static_cast<double>(time));
    }
  }
  if (!(first <= last)) return std::nullopt;
  return std::pair{first, last};
}

void apply(const ClipTime& clip, const Data& data, Model& model) {
  const Index number = animationNamed(model, clip.clip);
  const Animation& animation = model.animations[number];
  const std::string what = fmt::format("animations[{}]", number);
  model.leftOut.add("channels of animations by pointers (KHR_animation_pointer)", animation.pointers);
  for (const Animation::Channel& channel : animation.channels) {
    using Path = Animation::Path;
    Node& node = model.nodes[channel.node];
    const Animation::Sampler& sampler = animation.samplers[channel.sampler];
    const std::vector<float> times = data.fractions(sampler.input, what);
    const std::vector<float> values = data.fractions(sampler.output, what);
    const std::size_t keys = times.size() * (sampler.interpolation == Animation::Interpolation::CubicSpline ? 3 : 1);
    const std::size_t width = keys == 0 ? 0 : values.size() / keys;
    const std::size_t wanted = channel.path == Path::Rotation ? 4 : channel.path == Path::Weights ? width : 3;
    if (times.empty() || width == 0 || width != wanted || width * keys != values.size() ||
        !std::is_sorted(times.begin(), times.end())) {
      model.fail(
          fmt::format("is not valid glTF: a sampler of {} has numbers of times and values that do not match", what));
    }
    const KeyFrames frames(times, values, width, sampler.interpolation, clip.time);
    const std::vector<double> now = channel.path == Path::Rotation ? frames.rotation() : frames.numbers();
    if (channel.path == Path::Weights) {
      node.weights = now;
      continue;
    }
    node.matrix.reset();
    double* const into = channel.path == Path::Translation ? node.translation.data()
                         : channel.path == Path::Scale     ? node.scale.data()
                                                           : node.rotation.data();
    std::copy(now.begin(), now.end(), into);
  }
}

Affine localOf(const Node& node) {
  if (node.matrix) return toAffine(node.matrix->data());
  const auto& [x, y, z, w] = node.rotation;
  const double size = std::sqrt(x * x + y * y + z * z + w * w);
  const Quat q = size > 0 ? Quat{w / size, x / size, y / size, z / size} : Quat{};
  const auto vector = [](const std::array<double, 3>& v) { return Vec3d{v[0], v[1], v[2]}; };
  return {toMatrix(q) * Mat3::scale(vector(node.scale)), vector(node.translation)};
}

std::vector<PlacedNode> placeNodes(const Model& model) {
  std::vector<PlacedNode> placed;
  std::vector<PlacedNode> open;  // with the transform, the name and the visibility of their parents
  const auto add = [&](const std::vector<Index>& nodes, PlacedNode parent) {
    for (std::size_t i = nodes.size(); i-- > 0;) {
      parent.node = nodes[i];
      open.push_back(parent);
    }
  };
  add(model.roots, {});
  while (!open.empty()) {
    PlacedNode item = open.back();
    open.pop_back();
    const Node& node = model.nodes[item.node];
    if (!node.name.empty()) item.name = node.name;
    if (item.name.empty() && node.mesh) item.name = model.meshes[*node.mesh].name;
    item.sceneFromNode = item.sceneFromNode * localOf(node);
    item.visible = item.visible && node.visible;
    placed.push_back(item);
    add(node.children, item);
  }
  return placed;
}

Poser::Poser(const Model& model, const Data& data, const std::vector<PlacedNode>& placed)
    : model_(model), data_(data), placedOf_(model.nodes.size(), nullptr) {
  for (const PlacedNode& p : placed) placedOf_[p.node] = &p;
}

std::vector<double> Poser::weightsOf(const PlacedNode& node) const {
  const Node& n = model_.nodes[node.node];
  std::vector<double> weights = n.weights.empty() ? model_.meshes[*n.mesh].weights : n.weights;
  if (std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0; })) weights.clear();
  return weights;
}

bool Poser::isRigid(const PlacedNode& node) const {
  return !model_.nodes[node.node].skin && weightsOf(node).empty();
}

void Poser::pose(const PlacedNode& node, const Primitive& primitive, const AttributeNumbers& numbers,
                 const std::string& what, std::vector<Vec3d>& points) {
  const std::vector<double> weights = weightsOf(node);
  for (std::size_t t = 0; t < std::min(primitive.targets.size(), weights.size()); ++t) {
    const auto target = primitive.targets[t].find("POSITION");
    if (weights[t] == 0 || target == primitive.targets[t].end()) continue;
    const std::vector<Vec3d> offsets = toPoints(data_.finiteFloats(target->second, what));
    if (offsets.size() != points.size()) {
      model_.fail(fmt::format("is not valid glTF: {} and its morph target have different numbers of vertices", what));
    }
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = points[i] + offsets[i] * weights[t];
  }
  if (model_.nodes[node.node].skin) skin(node, numbers, what, points);
}

// Returns for each joint the transform from the mesh's frame to the scene's frame for vertices that follow this joint
// alone.
std::vector<Affine> Poser::jointsOf(const Skin& skin, const std::string& what) const {
  std::vector<float> inverses;
  if (skin.inverseBindMatrices) inverses = data_.fractions(*skin.inverseBindMatrices, what);
  std::vector<Affine> joints;
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    const PlacedNode* const placed = placedOf_[skin.joints[j]];
    if (placed == nullptr) {
      model_.fail(fmt::format("is not valid glTF: a joint of the skin of {} is not a node of the scene", what));
    }
    joints.push_back(placed->sceneFromNode * (inverses.empty() ? Affine{} : toAffine(&inverses[16 * j])));
  }
  return joints;
}

// Applies a node's skin. A vertex whose weights are all 0 follows its first joint; a vertex without joints follows the
// node.
void Poser::skin(const PlacedNode& node, const AttributeNumbers& numbers, const std::string& what,
                 std::vector<Vec3d>& points) const {
  const std::vector<Affine> joints = jointsOf(model_.skins[*model_.nodes[node.node].skin], what);
  std::vector<Vec3d> out(points.size());
  std::vector<double> sums(points.size(), 0);
  std::vector<std::size_t> firsts(points.size(), SIZE_MAX);
  for (int set = 0;; ++set) {
    const std::vector<float> which = numbers(fmt::format("JOINTS_{}", set));
    if (which.empty()) break;
    const std::vector<float> weights = numbers(fmt::format("WEIGHTS_{}", set));
    if (which.size() != 4 * points.size() || weights.size() != which.size()) {
      model_.fail(fmt::format("is not valid glTF: {} must have four joints and four weights per vertex", what));
    }
    for (std::size_t i = 0; i < which.size(); ++i) {
      const auto joint = static_cast<std::size_t>(which[i]);
      if (firsts[i / 4] == SIZE_MAX && joint < joints.size()) firsts[i / 4] = joint;
      if (weights[i] == 0) continue;
      if (joint >= joints.size()) {
        model_.fail(fmt::format("is not valid glTF: a vertex of {} refers to the joint {}, but its skin has {}", what,
                                joint, joints.size()));
      }
      out[i / 4] = out[i / 4] + (joints[joint] * points[i / 4]) * static_cast<double>(weights[i]);
      sums[i / 4] += static_cast<double>(weights[i]);
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Affine& follows = firsts[i] == SIZE_MAX ? node.sceneFromNode : joints[firsts[i]];
    points[i] = sums[i] > 0 ? out[i] * (1 / sums[i]) : follows * points[i];
  }
}

}  // namespace scanmill::gltf
