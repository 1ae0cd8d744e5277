#include "scene/assets/gltf_pose.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/base64.h"
#include "base/error.h"
#include "scene/assets/gltf_data.h"

namespace scanmill {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMostPosed = std::uint64_t{1} << 27;  // vertices

// Of 16 numbers, by columns.
template <class Number>
Affine toAffine(const Number* m) {
  const auto column = [&](std::size_t c) {
    return Vec3d{static_cast<double>(m[4 * c]), static_cast<double>(m[4 * c + 1]), static_cast<double>(m[4 * c + 2])};
  };
  return {{column(0), column(1), column(2)}, column(3)};
}

Affine localOf(const Json& node) {
  if (const auto m = node.find("matrix"); m != node.end()) return toAffine(m->get<std::vector<double>>().data());
  const auto numbers = [&](const char* key, const std::vector<double>& fallback) {
    const auto found = node.find(key);
    return found == node.end() ? fallback : found->get<std::vector<double>>();
  };
  const std::vector<double> t = numbers("translation", {0, 0, 0});
  const std::vector<double> r = numbers("rotation", {0, 0, 0, 1});
  const std::vector<double> s = numbers("scale", {1, 1, 1});
  const double size = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  const Quat q = size > 0 ? Quat{r[3] / size, r[0] / size, r[1] / size, r[2] / size} : Quat{};
  return {toMatrix(q) * Mat3::scale({s[0], s[1], s[2]}), {t[0], t[1], t[2]}};
}

// The values of an animation's sampler at a time: so many numbers, or a rotation.
std::vector<double> sampled(const std::vector<float>& times, const std::vector<float>& values, std::size_t width,
                            const std::string& interpolation, bool rotation, double time) {
  const bool cubic = interpolation == "CUBICSPLINE";
  const std::size_t stride = width * (cubic ? 3 : 1);
  // Of a cubic spline: in-tangent 0, value 1, out-tangent 2 (appendix C.5).
  const auto value = [&](std::size_t key, std::size_t which, std::size_t i) {
    return static_cast<double>(values[key * stride + (cubic ? which * width : 0) + i]);
  };
  const auto after = std::upper_bound(times.begin(), times.end(), static_cast<float>(time));
  const std::size_t b = std::min(static_cast<std::size_t>(after - times.begin()), times.size() - 1);
  const std::size_t a = after == times.begin() ? 0 : static_cast<std::size_t>(after - times.begin()) - 1;
  const double span = static_cast<double>(times[b]) - static_cast<double>(times[a]);
  const double t = span > 0 ? std::clamp((time - static_cast<double>(times[a])) / span, 0.0, 1.0) : 0;
  std::vector<double> out(width);
  for (std::size_t i = 0; i < width; ++i) {
    if (interpolation == "STEP" || a == b) {
      out[i] = value(a, 1, i);
    } else if (cubic) {
      const double t2 = t * t;
      const double t3 = t2 * t;
      out[i] = (2 * t3 - 3 * t2 + 1) * value(a, 1, i) + span * (t3 - 2 * t2 + t) * value(a, 2, i) +
               (3 * t2 - 2 * t3) * value(b, 1, i) + span * (t3 - t2) * value(b, 0, i);
    } else {
      out[i] = value(a, 1, i) + (value(b, 1, i) - value(a, 1, i)) * t;
    }
  }
  if (!rotation) return out;
  if (interpolation != "STEP" && !cubic && a != b) {
    const auto quat = [&](std::size_t k) {
      return Quat{value(k, 1, 3), value(k, 1, 0), value(k, 1, 1), value(k, 1, 2)};
    };
    const Quat q = slerp(quat(a), quat(b), t);
    out = {q.x, q.y, q.z, q.w};
  }
  const double size = std::sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2] + out[3] * out[3]);
  if (!(size > 0)) return {0, 0, 0, 1};
  for (double& number : out) number /= size;
  return out;
}

class Poser {
 public:
  Poser(GltfContainer container, const std::filesystem::path& file)
      : file_(file), container_(std::move(container)), json_(Json::parse(container_.json)), data_(container_, file) {}

  GltfContainer run(const std::optional<ClipTime>& clip) {
    try {
      if (clip) apply(*clip);
      placeNodes();
      for (const std::size_t node : order_) pose(node);
      finish();
    } catch (const Json::exception& e) {
      fail(fmt::format("is not valid glTF: {}", e.what()));
    }
    container_.json = json_.dump();
    return std::move(container_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_.string()}, what); }

  // Beyond all that there can be where it is no index.
  static std::size_t indexOf(const Json& value) {
    return value.is_number_unsigned() ? value.get<std::size_t>() : SIZE_MAX;
  }

  Json& element(const char* list, const Json& index, const std::string& what) {
    Json& all = json_[list];
    if (!all.is_array() || indexOf(index) >= all.size()) {
      fail(fmt::format("is not valid glTF: {} is none of the {}", what, list));
    }
    return all[indexOf(index)];
  }

  // Writes what the clip says into the nodes.
  void apply(const ClipTime& clip) {
    const std::size_t number = data_.clip(clip.clip);
    const Json& animation = json_["animations"][number];
    const std::string what = fmt::format("animations[{}]", number);
    for (const Json& channel : animation.at("channels")) {
      const Json& target = channel.at("target");
      if (!target.contains("node")) continue;  // what extensions move
      const std::string path = target.at("path").get<std::string>();
      const bool places = path == "translation" || path == "rotation" || path == "scale";
      if (!places && path != "weights") continue;  // likewise
      Json& node = element("nodes", target["node"], what + "'s target");
      const Json& samplers = animation.at("samplers");
      const std::size_t index = indexOf(channel.at("sampler"));
      if (index >= samplers.size()) fail(fmt::format("is not valid glTF: a channel of {} has no sampler", what));
      const Json& sampler = samplers[index];
      const std::string interpolation = sampler.value("interpolation", std::string("LINEAR"));
      const std::vector<float> times = data_.floats(indexOf(sampler.at("input")), what);
      const std::vector<float> values = data_.floats(indexOf(sampler.at("output")), what);
      const std::size_t keys = times.size() * (interpolation == "CUBICSPLINE" ? 3 : 1);
      const std::size_t width = keys == 0 ? 0 : values.size() / keys;
      const std::size_t wanted = path == "rotation" ? 4 : path == "weights" ? width : 3;
      if (times.empty() || width == 0 || width != wanted || width * keys != values.size() ||
          !std::is_sorted(times.begin(), times.end())) {
        fail(fmt::format("is not valid glTF: a sampler of {} has times and values that do not fit", what));
      }
      node[path] = sampled(times, values, width, interpolation, path == "rotation", clip.time);
      if (places) node.erase("matrix");
    }
  }

  // The transforms of all nodes of the scene, in file order (depth first), and the names that unnamed ones inherit.
  void placeNodes() {
    struct Item {
      std::size_t node;
      Affine parent;
      std::string name;
    };
    std::vector<Item> open;
    const auto add = [&](const Json& children, const Affine& parent, const std::string& name) {
      for (auto child = children.rbegin(); child != children.rend(); ++child) {
        open.push_back({child->get<std::size_t>(), parent, name});
      }
    };
    const Json& nodes = json_["nodes"];
    const Json& scene = json_["scenes"][json_["scene"].get<std::size_t>()];
    if (scene.contains("nodes")) add(scene["nodes"], {}, {});
    while (!open.empty()) {
      const Item item = open.back();
      open.pop_back();
      const Json& node = nodes[item.node];
      Placed& placed = placed_[item.node];
      placed.sceneFromNode = item.parent * localOf(node);
      placed.name = node.value("name", std::string());
      if (placed.name.empty()) placed.name = item.name;
      order_.push_back(item.node);
      if (node.contains("children")) add(node["children"], placed.sceneFromNode, placed.name);
    }
  }

  void pose(std::size_t number) {
    const Json node = json_["nodes"][number];
    if (!node.contains("mesh")) return;
    const Json mesh = element("meshes", node["mesh"], "a node's mesh");
    std::vector<double> weights;
    if (mesh.contains("weights")) weights = mesh["weights"].get<std::vector<double>>();
    if (node.contains("weights")) weights = node["weights"].get<std::vector<double>>();
    const bool morphs = std::any_of(weights.begin(), weights.end(), [](double w) { return w != 0; });
    const bool skinned = node.contains("skin");
    if (!morphs && !skinned) return;
    const std::string what = fmt::format("the mesh of '{}'", placed_[number].name);
    std::vector<Affine> joints;
    if (skinned) joints = jointsOf(element("skins", node["skin"], "a node's skin"), what);

    Json posed = mesh;
    for (Json& primitive : posed["primitives"]) {
      if (primitive.contains("extensions") && primitive["extensions"].contains("KHR_draco_mesh_compression")) {
        warn(
            fmt::format("{}: {} is compressed and stays as it is modelled: export it without compression to have it "
                        "posed",
                        file_.string(), what));
        return;
      }
      std::vector<Vec3d> points = morphed(primitive, weights, what);
      if (skinned) skin(primitive, joints, placed_[number].sceneFromNode, what, points);
      primitive["attributes"]["POSITION"] = addPositions(points);
    }
    const std::size_t meshNumber = json_["meshes"].size();
    json_["meshes"].push_back(std::move(posed));
    if (!skinned) {
      json_["nodes"][number]["mesh"] = meshNumber;
      return;
    }
    // The vertices are where the joints have put them, wherever the node is.
    json_["nodes"][number].erase("mesh");
    const std::size_t root = json_["nodes"].size();
    json_["nodes"].push_back({{"name", placed_[number].name}, {"mesh", meshNumber}});
    json_["scenes"][json_["scene"].get<std::size_t>()]["nodes"].push_back(root);
  }

  // What takes a vertex of the mesh to where each joint would have it.
  std::vector<Affine> jointsOf(const Json& skin, const std::string& what) {
    const Json& list = skin.at("joints");
    std::vector<float> inverses;
    if (skin.contains("inverseBindMatrices")) inverses = data_.floats(indexOf(skin["inverseBindMatrices"]), what);
    if (!inverses.empty() && inverses.size() < 16 * list.size()) {
      fail(fmt::format("is not valid glTF: the skin of {} has fewer matrices than joints", what));
    }
    std::vector<Affine> joints;
    for (std::size_t j = 0; j < list.size(); ++j) {
      const auto placed = placed_.find(indexOf(list[j]));
      if (placed == placed_.end()) {
        fail(fmt::format("is not valid glTF: a joint of the skin of {} is no node of the scene", what));
      }
      const Affine jointFromMesh = inverses.empty() ? Affine{} : toAffine(&inverses[16 * j]);
      joints.push_back(placed->second.sceneFromNode * jointFromMesh);
    }
    return joints;
  }

  std::vector<Vec3d> morphed(const Json& primitive, const std::vector<double>& weights, const std::string& what) {
    const auto positions = [&](const Json& accessor) {
      const std::vector<float> values = data_.floats(indexOf(accessor), what);
      std::vector<Vec3d> points;
      for (std::size_t i = 0; i + 2 < values.size(); i += 3)
        points.emplace_back(Vec3f{values[i], values[i + 1], values[i + 2]});
      return points;
    };
    std::vector<Vec3d> points = positions(primitive.at("attributes").at("POSITION"));
    posed_ += points.size();
    if (posed_ > kMostPosed) fail(fmt::format("poses over {} vertices", kMostPosed));
    const Json none = Json::array();
    const Json& targets = primitive.contains("targets") ? primitive["targets"] : none;
    for (std::size_t t = 0; t < std::min(targets.size(), weights.size()); ++t) {
      if (weights[t] == 0 || !targets[t].contains("POSITION")) continue;
      const std::vector<Vec3d> offsets = positions(targets[t]["POSITION"]);
      if (offsets.size() != points.size()) {
        fail(fmt::format("is not valid glTF: a morph target of {} has not as many vertices as it", what));
      }
      for (std::size_t i = 0; i < points.size(); ++i) points[i] = points[i] + offsets[i] * weights[t];
    }
    return points;
  }

  // What hangs on no joint by any weight follows its first, and a part without joints its node.
  void skin(const Json& primitive, const std::vector<Affine>& joints, const Affine& sceneFromNode,
            const std::string& what, std::vector<Vec3d>& points) {
    const Json& attributes = primitive.at("attributes");
    std::vector<Vec3d> out(points.size());
    std::vector<double> sums(points.size(), 0);
    std::vector<std::size_t> firsts(points.size(), SIZE_MAX);
    for (int set = 0; attributes.contains(fmt::format("JOINTS_{}", set)); ++set) {
      const std::vector<float> which = data_.indices(indexOf(attributes[fmt::format("JOINTS_{}", set)]), what);
      const std::vector<float> weights = data_.floats(indexOf(attributes.at(fmt::format("WEIGHTS_{}", set))), what);
      if (which.size() != 4 * points.size() || weights.size() != which.size()) {
        fail(fmt::format("is not valid glTF: {} has not four joints and weights a vertex", what));
      }
      for (std::size_t i = 0; i < which.size(); ++i) {
        const auto joint = static_cast<std::size_t>(which[i]);
        if (firsts[i / 4] == SIZE_MAX && joint < joints.size()) firsts[i / 4] = joint;
        if (weights[i] == 0) continue;
        if (joint >= joints.size()) {
          fail(fmt::format("is not valid glTF: a vertex of {} hangs on the joint {} of a skin with {}", what, joint,
                           joints.size()));
        }
        out[i / 4] = out[i / 4] + (joints[joint] * points[i / 4]) * static_cast<double>(weights[i]);
        sums[i / 4] += static_cast<double>(weights[i]);
      }
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Affine& follows = firsts[i] == SIZE_MAX ? sceneFromNode : joints[firsts[i]];
      points[i] = sums[i] > 0 ? out[i] * (1 / sums[i]) : follows * points[i];
    }
  }

  // A new accessor.
  std::size_t addPositions(const std::vector<Vec3d>& points) {
    std::string bytes;
    bytes.reserve(points.size() * sizeof(Vec3f));
    for (const Vec3d& p : points) {
      const Vec3f f(p);
      bytes.append(reinterpret_cast<const char*>(&f), sizeof f);
    }
    const std::size_t buffer = json_["buffers"].size();
    json_["buffers"].push_back(
        {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}});
    json_["bufferViews"].push_back({{"buffer", buffer}, {"byteLength", bytes.size()}});
    json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                  {"componentType", 5126},
                                  {"type", "VEC3"},
                                  {"count", points.size()}});
    return json_["accessors"].size() - 1;
  }

  // What is no longer needed, and what the importer should not see.
  void finish() {
    for (const char* key : {"animations", "skins"}) json_.erase(key);
    for (Json& node : json_["nodes"]) {
      for (const char* key : {"skin", "weights"}) node.erase(key);
    }
    for (Json& mesh : json_["meshes"]) {
      mesh.erase("weights");
      for (Json& primitive : mesh["primitives"]) {
        primitive.erase("targets");
        Json kept = Json::object();
        for (const auto& [name, accessor] : primitive["attributes"].items()) {
          if (!name.starts_with("JOINTS_") && !name.starts_with("WEIGHTS_")) kept[name] = accessor;
        }
        primitive["attributes"] = std::move(kept);
      }
    }
  }

  struct Placed {
    Affine sceneFromNode;
    std::string name;
  };

  const std::filesystem::path& file_;
  GltfContainer container_;
  Json json_;
  GltfData data_;
  std::map<std::size_t, Placed> placed_;
  std::vector<std::size_t> order_;
  std::uint64_t posed_ = 0;
};

}  // namespace

GltfContainer posedGltf(GltfContainer container, const std::filesystem::path& file,
                        const std::optional<ClipTime>& clip) {
  return Poser(std::move(container), file).run(clip);
}

}  // namespace scanmill
