#include "assets/meshes/gltf/pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/fields.h"

namespace scanmill::gltf {
namespace {

// Returns the value of an animated property at a time (s), as `width` numbers; rotations are unit quaternions (x, y, z,
// w). `times`: the times of the key frames (s), at least one, ascending. `values`: the values of all key frames; for
// cubic splines each value stands between its in-tangent and its out-tangent (appendix C.5).
std::vector<double> propertyAt(double time, const std::vector<float>& times, const std::vector<float>& values,
                               std::size_t width, Animation::Interpolation interpolation, Animation::Path path) {
  using Interpolation = Animation::Interpolation;
  enum Part { InTangent, Value, OutTangent };
  const auto numberAt = [&](std::size_t key, Part part, std::size_t i) {
    const bool isCubic = interpolation == Interpolation::CubicSpline;
    return static_cast<double>(values[isCubic ? (3 * key + part) * width + i : key * width + i]);
  };
  const auto later =
      static_cast<std::size_t>(std::ranges::upper_bound(times, static_cast<float>(time)) - times.begin());
  // Indices of the key frames before and after the time; equal if the time is before the first or after the last one.
  const std::size_t before = later == 0 ? 0 : later - 1, after = std::min(later, times.size() - 1);
  const double span = static_cast<double>(times[after]) - static_cast<double>(times[before]);
  const double t = span > 0 ? std::clamp((time - static_cast<double>(times[before])) / span, 0.0, 1.0) : 0;
  const double t2 = t * t, t3 = t2 * t;
  std::vector<double> numbers(width);
  for (std::size_t i = 0; i < width; ++i) {
    const double start = numberAt(before, Value, i), end = numberAt(after, Value, i);
    if (interpolation == Interpolation::Step || before == after) {
      numbers[i] = start;
    } else if (interpolation == Interpolation::CubicSpline) {
      numbers[i] = (2 * t3 - 3 * t2 + 1) * start + span * (t3 - 2 * t2 + t) * numberAt(before, OutTangent, i) +
                   (3 * t2 - 2 * t3) * end + span * (t3 - t2) * numberAt(after, InTangent, i);
    } else {
      numbers[i] = start + (end - start) * t;
    }
  }
  if (path != Animation::Path::Rotation) return numbers;
  const auto quaternionAt = [&](std::size_t key) {
    return Quat{numberAt(key, Value, 3), numberAt(key, Value, 0), numberAt(key, Value, 1), numberAt(key, Value, 2)};
  };
  if (interpolation == Interpolation::Linear && before != after) {
    const auto [w, x, y, z] = slerp(quaternionAt(before), quaternionAt(after), t);
    numbers = {x, y, z, w};
  }
  const double norm =
      std::sqrt(numbers[0] * numbers[0] + numbers[1] * numbers[1] + numbers[2] * numbers[2] + numbers[3] * numbers[3]);
  if (!(norm > 0)) return {0, 0, 0, 1};
  for (double& number : numbers) number /= norm;
  return numbers;
}

}  // namespace

std::string nameOf(const Model& model, Index animation) {
  const std::string& name = model.animations[animation].name;
  return name.empty() ? std::to_string(animation) : name;
}

Index animationNamed(const Model& model, const std::string& name) {
  std::vector<std::string> names;
  for (Index i = 0; i < model.animations.size(); ++i) names.push_back(nameOf(model, i));
  const auto named = std::ranges::find(names, name);
  if (named != names.end()) return static_cast<Index>(named - names.begin());
  for (Index i = 0; i < names.size(); ++i) {
    if (std::to_string(i) == name) return i;
  }
  if (names.empty()) model.fail("has no animation");
  model.fail("has no animation '{}'{}", name, suggestion(name, names));
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
    const std::size_t valueCount = times.size() * (isCubic ? 3 : 1);  // cubic splines: with tangents
    const std::size_t width = valueCount == 0 ? 0 : values.size() / valueCount;
    const std::size_t widthOfPath = channel.path == Path::Rotation ? 4 : channel.path == Path::Weights ? width : 3;
    if (times.empty() || width == 0 || width != widthOfPath || width * valueCount != values.size() ||
        !std::ranges::is_sorted(times)) {
      model.fail("is not valid glTF: a sampler of {} has numbers of times and values that do not match", what);
    }
    const std::vector<double> value = propertyAt(clip.time, times, values, width, sampler.interpolation, channel.path);
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
