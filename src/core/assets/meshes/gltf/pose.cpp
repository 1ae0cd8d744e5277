#include "assets/meshes/gltf/pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/fields.h"

namespace scanmill::gltf {
namespace {

// The key frames of a sampler, and a time between two of them.
class KeyFrames {
 public:
  // `times` (s): of the key frames, ascending, one at least. `values`: of all key frames; `width`: numbers per value.
  KeyFrames(const std::vector<float>& times, const std::vector<float>& values, std::size_t width,
            Animation::Interpolation interpolation, double time)
      : values_(values), width_(width), interpolation_(interpolation) {
    const auto firstLater =
        static_cast<std::size_t>(std::ranges::upper_bound(times, static_cast<float>(time)) - times.begin());
    before_ = firstLater == 0 ? 0 : firstLater - 1;
    after_ = std::min(firstLater, times.size() - 1);
    span_ = static_cast<double>(times[after_]) - static_cast<double>(times[before_]);
    if (span_ > 0) fraction_ = std::clamp((time - static_cast<double>(times[before_])) / span_, 0.0, 1.0);
  }

  // Returns the interpolated value. The formula of cubic splines is that of appendix C.5.
  std::vector<double> value() const {
    const double t = fraction_, t2 = t * t, t3 = t2 * t;
    std::vector<double> numbers(width_);
    for (std::size_t i = 0; i < width_; ++i) {
      const double start = numberAt(before_, Value, i), end = numberAt(after_, Value, i);
      if (interpolation_ == Animation::Interpolation::Step || before_ == after_) {
        numbers[i] = start;
      } else if (interpolation_ == Animation::Interpolation::CubicSpline) {
        numbers[i] = (2 * t3 - 3 * t2 + 1) * start + span_ * (t3 - 2 * t2 + t) * numberAt(before_, OutTangent, i) +
                     (3 * t2 - 2 * t3) * end + span_ * (t3 - t2) * numberAt(after_, InTangent, i);
      } else {
        numbers[i] = start + (end - start) * t;
      }
    }
    return numbers;
  }

  // Returns the interpolated rotation as a unit quaternion (x, y, z, w).
  std::vector<double> rotation() const {
    std::vector<double> q = value();
    if (interpolation_ == Animation::Interpolation::Linear && before_ != after_) {
      const auto [w, x, y, z] = slerp(quaternion(before_), quaternion(after_), fraction_);
      q = {x, y, z, w};
    }
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(norm > 0)) return {0, 0, 0, 1};
    for (double& number : q) number /= norm;
    return q;
  }

 private:
  enum Part { InTangent, Value, OutTangent };  // of a key frame of a cubic spline; others have only a value

  double numberAt(std::size_t key, Part part, std::size_t i) const {
    const bool isCubic = interpolation_ == Animation::Interpolation::CubicSpline;
    return static_cast<double>(values_[isCubic ? (3 * key + part) * width_ + i : key * width_ + i]);
  }

  Quat quaternion(std::size_t key) const {
    return {numberAt(key, Value, 3), numberAt(key, Value, 0), numberAt(key, Value, 1), numberAt(key, Value, 2)};
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
  return first <= last ? std::optional(std::pair{first, last}) : std::nullopt;
}

void apply(const ClipTime& clip, const Data& data, Model& model) {
  const Index index = animationNamed(model, clip.clip);
  const Animation& animation = model.animations[index];
  const std::string what = fmt::format("animations[{}]", index);
  model.leftOut.add("channels of animations by pointers (KHR_animation_pointer)", animation.pointers);
  for (const Animation::Channel& channel : animation.channels) {
    using Path = Animation::Path;
    Node& node = model.nodes[channel.node];
    const Animation::Sampler& sampler = animation.samplers[channel.sampler];
    const std::vector<float> times = data.fractions(sampler.input, what);
    const std::vector<float> values = data.fractions(sampler.output, what);
    const bool isCubic = sampler.interpolation == Animation::Interpolation::CubicSpline;
    const std::size_t valueCount = times.size() * (isCubic ? 3 : 1);  // with tangents
    const std::size_t width = valueCount == 0 ? 0 : values.size() / valueCount;
    const std::size_t widthOfPath = channel.path == Path::Rotation ? 4 : channel.path == Path::Weights ? width : 3;
    if (times.empty() || width == 0 || width != widthOfPath || width * valueCount != values.size() ||
        !std::ranges::is_sorted(times)) {
      model.fail(
          fmt::format("is not valid glTF: a sampler of {} has numbers of times and values that do not match", what));
    }
    const KeyFrames frames(times, values, width, sampler.interpolation, clip.time);
    const std::vector<double> value = channel.path == Path::Rotation ? frames.rotation() : frames.value();
    if (channel.path == Path::Weights) {
      node.weights = value;
      continue;
    }
    node.matrix.reset();
    double* const target = channel.path == Path::Translation ? node.translation.data()
                           : channel.path == Path::Scale     ? node.scale.data()
                                                             : node.rotation.data();
    std::ranges::copy(value, target);
  }
}

Affine localOf(const Node& node) {
  if (node.matrix) return toAffine(node.matrix->data());
  const auto& [x, y, z, w] = node.rotation;
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  const Quat q = norm > 0 ? Quat{w / norm, x / norm, y / norm, z / norm} : Quat{};
  const auto vector = [](const std::array<double, 3>& v) { return Vec3d{v[0], v[1], v[2]}; };
  return {toMatrix(q) * Mat3::scale(vector(node.scale)), vector(node.translation)};
}

std::vector<PlacedNode> placeNodes(const Model& model) {
  std::vector<PlacedNode> placedNodes;
  std::vector<PlacedNode> pending;  // with the transform, the name and the visibility of their parents
  const auto addPending = [&](const std::vector<Index>& nodes, PlacedNode parent) {
    for (std::size_t i = nodes.size(); i-- > 0;) {
      parent.node = nodes[i];
      pending.push_back(parent);
    }
  };
  addPending(model.roots, {});
  while (!pending.empty()) {
    PlacedNode placed = pending.back();
    pending.pop_back();
    const Node& node = model.nodes[placed.node];
    if (!node.name.empty()) placed.name = node.name;
    if (placed.name.empty() && node.mesh) placed.name = model.meshes[*node.mesh].name;
    placed.sceneFromNode = placed.sceneFromNode * localOf(node);
    placed.visible = placed.visible && node.visible;
    placedNodes.push_back(placed);
    addPending(node.children, placed);
  }
  return placedNodes;
}

}  // namespace scanmill::gltf
