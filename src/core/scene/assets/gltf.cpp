#include "scene/assets/gltf.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "scene/assets/gltf_container.h"
#include "scene/assets/gltf_data.h"
#include "scene/assets/gltf_pose.h"

namespace scanmill {

namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMaxCount = std::uint64_t{1} << 31;
constexpr int kMaxDepth = 512;  // the importer recurses

class Checker {
 public:
  explicit Checker(std::filesystem::path file) : file_(std::move(file)), container_(readGltfContainer(file_)) {}

  GltfContainer run(bool posed) {
    try {
      json_ = Json::parse(container_.json);
      check(posed);
    } catch (const Json::exception& e) {
      fail(fmt::format("is not valid glTF: {}", e.what()));
    }
    container_.json = json_.dump(-1, ' ', false, Json::error_handler_t::replace);
    return std::move(container_);
  }

  // Whether anything in it can be posed: skins, or morph targets that are not at rest.
  bool poses() const { return poses_; }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_.string()}, what); }

  // The array under a key of the root, made where it is absent.
  Json& list(const char* key) {
    Json& value = json_[key];
    if (value.is_null()) value = Json::array();
    if (!value.is_array()) fail(fmt::format("is not valid glTF: '{}' is not a list", key));
    return value;
  }

  // An element's key as an index below `count`.
  std::size_t index(const Json& value, std::size_t count, const std::string& what) const {
    if (!value.is_number_unsigned()) fail(fmt::format("is not valid glTF: {} is not an index", what));
    const std::uint64_t i = value.get<std::uint64_t>();
    if (i >= count) fail(fmt::format("is not valid glTF: {} is {}, but there are {}", what, i, count));
    return i;
  }

  std::uint64_t count(const Json& object, const char* key, std::uint64_t fallback, const std::string& what) const {
    const auto found = object.find(key);
    if (found == object.end()) return fallback;
    if (!found->is_number_unsigned() || found->get<std::uint64_t>() > UINT64_MAX / 4) {
      fail(fmt::format("is not valid glTF: {}.{} is not a length", what, key));
    }
    return found->get<std::uint64_t>();
  }

  void check(bool posed) {
    if (!json_.is_object()) fail("is not valid glTF: the file is not a JSON object");
    const auto asset = json_.find("asset");
    if (asset == json_.end() || !asset->is_object()) fail("is not glTF: 'asset' is missing");
    const std::string version = asset->value("version", std::string());
    if (!version.starts_with("2.")) {
      fail(fmt::format("is glTF {}: only 2.0 is read, export it again", version.empty() ? "of no version" : version));
    }
    refuseExtensions();
    for (const char* key : {"cameras", "samplers", "extensions"}) json_.erase(key);
    poses_ = posed || isPosed();
    if (!poses_) {
      for (const char* key : {"animations", "skins"}) json_.erase(key);
    }
    checkBuffers();
    checkViews();
    checkAccessors();
    checkImages();
    checkMaterials();
    checkMeshes();
    checkNodes();
  }

  bool isPosed() const {
    for (const char* key : {"nodes", "meshes"}) {
      const auto found = json_.find(key);
      if (found == json_.end() || !found->is_array()) continue;
      if (std::any_of(found->begin(), found->end(), [](const Json& one) {
            return one.is_object() && (one.contains("skin") || one.contains("weights"));
          })) {
        return true;
      }
    }
    return false;
  }

  void refuseExtensions() {
    Json& required = list("extensionsRequired");
    for (const Json& name : required) {
      const std::string extension = name.get<std::string>();
      if (extension == "EXT_meshopt_compression" || extension == "KHR_mesh_quantization") {
        fail(fmt::format("needs {}: export it as glTF without compression or quantisation", extension));
      }
    }
  }

  void checkBuffers() {
    Json& buffers = list("buffers");
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      Json& buffer = buffers[i];
      const std::string what = fmt::format("buffers[{}]", i);
      const std::uint64_t length = count(buffer, "byteLength", 0, what);
      std::uint64_t present = 0;
      std::string place = "the GLB's binary chunk";
      if (buffer.contains("uri")) {
        const std::string uri = buffer["uri"].get<std::string>();
        if (uri.starts_with("data:")) {
          const std::size_t comma = uri.find(',');
          if (comma == std::string::npos || uri.find(";base64") > comma) fail(what + " is not base64 data");
          std::size_t end = uri.size();
          while (end > comma + 1 && uri[end - 1] == '=') --end;
          present = (end - comma - 1) * 3 / 4;
          place = "its data";
        } else {
          const std::string name = decodeUri(uri);
          const std::filesystem::path path = file_.parent_path() / name;
          std::error_code error;
          if (!std::filesystem::is_regular_file(path, error)) {
            fail(fmt::format("names the buffer '{}', which is missing: put it beside the file", name));
          }
          present = std::filesystem::file_size(path, error);
          place = "'" + name + "'";
          buffer["uri"] = name;
        }
      } else {
        present = container_.bin.size();
      }
      if (length > present) {
        fail(fmt::format("{} has {} bytes, but {} holds {}: is it truncated?", what, length, place, present));
      }
    }
  }

  void checkViews() {
    const Json& buffers = list("buffers");
    const Json& views = list("bufferViews");
    for (std::size_t i = 0; i < views.size(); ++i) {
      const std::string what = fmt::format("bufferViews[{}]", i);
      const std::size_t buffer = index(views[i].at("buffer"), buffers.size(), what + ".buffer");
      const std::uint64_t end = count(views[i], "byteOffset", 0, what) + count(views[i], "byteLength", 0, what);
      if (end > buffers[buffer].value("byteLength", std::uint64_t{0})) fail(what + " reaches beyond its buffer");
      if (count(views[i], "byteStride", 4, what) > 252) fail(what + " has a byteStride over 252");
      if (views[i].contains("extensions") && views[i]["extensions"].contains("EXT_meshopt_compression")) {
        fail("needs EXT_meshopt_compression: export it as glTF without compression");
      }
    }
  }

  static std::uint64_t componentSize(const Json& accessor) {
    switch (accessor.value("componentType", 0)) {
      case 5120:
      case 5121:
        return 1;
      case 5122:
      case 5123:
        return 2;
      case 5125:
      case 5126:
        return 4;
      default:
        return 0;
    }
  }

  static std::uint64_t components(const Json& accessor) {
    static constexpr std::array<std::pair<std::string_view, std::uint64_t>, 7> kTypes{
        {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
    const std::string type = accessor.value("type", std::string());
    for (const auto& [name, size] : kTypes) {
      if (name == type) return size;
    }
    return 0;
  }

  void checkAccessors() {
    const Json& views = list("bufferViews");
    Json& accessors = list("accessors");
    for (std::size_t i = 0; i < accessors.size(); ++i) {
      const Json& accessor = accessors[i];
      const std::string what = fmt::format("accessors[{}]", i);
      const std::uint64_t size = componentSize(accessor) * components(accessor);
      if (size == 0) fail(what + " has an unknown type");
      const std::uint64_t n = count(accessor, "count", 0, what);
      if (n > kMaxCount) fail(what + " has an absurd count");
      if (accessor.contains("sparse")) fail(what + " is sparse: export it as glTF without sparse accessors");
      if (!accessor.contains("bufferView")) continue;  // the data are compressed, or zeroes
      const Json& view = views[index(accessor["bufferView"], views.size(), what + ".bufferView")];
      const std::uint64_t stride = count(view, "byteStride", size, what);
      const std::uint64_t offset = count(accessor, "byteOffset", 0, what);
      if (stride < size) fail(what + " has elements that overlap");
      if (n > 0 && offset + (n - 1) * stride + size > count(view, "byteLength", 0, what)) {
        fail(what + " reaches beyond its bufferView: is the file truncated?");
      }
    }
  }

  void checkImages() {
    const Json& views = list("bufferViews");
    Json& images = list("images");
    for (std::size_t i = 0; i < images.size(); ++i) {
      const std::string what = fmt::format("images[{}]", i);
      if (images[i].contains("bufferView")) index(images[i]["bufferView"], views.size(), what + ".bufferView");
      if (!images[i].contains("uri")) continue;
      const std::string uri = images[i]["uri"].get<std::string>();
      if (!uri.starts_with("data:")) images[i]["uri"] = decodeUri(uri);
    }
    Json& textures = list("textures");
    for (std::size_t i = 0; i < textures.size(); ++i) {
      Json& texture = textures[i];
      texture.erase("sampler");
      if (!texture.contains("source") && texture.contains("extensions")) {
        for (const Json& extension : texture["extensions"]) {
          if (extension.is_object() && extension.contains("source")) texture["source"] = extension["source"];
        }
      }
      if (texture.contains("source")) index(texture["source"], images.size(), fmt::format("textures[{}].source", i));
    }
  }

  // Texture references may stand anywhere in a material and its extensions: {"index": n}.
  void checkReferences(const Json& value, const std::string& what, int depth) {
    if (depth > 16) fail(what + " is nested too deeply");
    if (!value.is_structured()) return;
    for (const auto& [key, child] : value.items()) {
      if (value.is_object() && key.ends_with("exture") && child.is_object() && child.contains("index")) {
        index(child["index"], list("textures").size(), what + "." + key);
      }
      checkReferences(child, what, depth + 1);
    }
  }

  void checkMaterials() {
    const Json& materials = list("materials");
    for (std::size_t i = 0; i < materials.size(); ++i)
      checkReferences(materials[i], fmt::format("materials[{}]", i), 0);
  }

  void checkMeshes() {
    Json& meshes = list("meshes");
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      if (!poses_) meshes[i].erase("weights");
      Json& primitives = meshes[i].at("primitives");
      if (!primitives.is_array()) fail(fmt::format("meshes[{}].primitives is not a list", i));
      Json kept = Json::array();
      for (std::size_t k = 0; k < primitives.size(); ++k) {
        if (checkPrimitive(primitives[k], fmt::format("meshes[{}].primitives[{}]", i, k)))
          kept.push_back(primitives[k]);
      }
      primitives = std::move(kept);
    }
  }

  // False for points and lines, and for what has no positions.
  bool checkPrimitive(Json& primitive, const std::string& what) {
    const Json& accessors = list("accessors");
    const std::uint64_t mode = count(primitive, "mode", 4, what);
    if (mode > 6) fail(what + " has an unknown mode");
    if (mode < 4) return false;
    if (!poses_) primitive.erase("targets");
    if (primitive.contains("material")) {
      index(primitive["material"], list("materials").size(), what + ".material");
    }
    if (!primitive.contains("attributes") || !primitive["attributes"].contains("POSITION")) return false;
    const Json attributes = primitive["attributes"];
    const Json& position = accessors[index(attributes["POSITION"], accessors.size(), what + ".POSITION")];
    if (components(position) != 3 || position.value("componentType", 0) != 5126) {
      fail(what + " has positions that are not 3 floats: export it as glTF without quantisation");
    }
    const std::uint64_t vertices = position.value("count", std::uint64_t{0});
    if (primitive.contains("indices")) {
      const Json& indices = accessors[index(primitive["indices"], accessors.size(), what + ".indices")];
      if (components(indices) != 1) fail(what + " has indices that are not scalars");
    }
    const bool compressed =
        primitive.contains("extensions") && primitive["extensions"].contains("KHR_draco_mesh_compression");
    if (compressed) {
      const Json& draco = primitive["extensions"]["KHR_draco_mesh_compression"];
      index(draco.at("bufferView"), list("bufferViews").size(), what + ".bufferView");
      for (const auto& [name, accessor] : attributes.items()) index(accessor, accessors.size(), what + "." + name);
      return vertices > 0;
    }
    if (!position.contains("bufferView")) return false;
    if (primitive.contains("indices") && !accessors[primitive["indices"].get<std::size_t>()].contains("bufferView")) {
      fail(what + " has indices without data");
    }
    Json kept = {{"POSITION", attributes["POSITION"]}};
    for (int set = 0;; ++set) {  // the importer wants them numbered without a gap
      const std::string name = fmt::format("TEXCOORD_{}", set);
      if (!attributes.contains(name)) break;
      const Json& accessor = accessors[index(attributes[name], accessors.size(), what + "." + name)];
      const bool plain = components(accessor) == 2 && accessor.value("componentType", 0) == 5126;
      if (!plain) warn(fmt::format("{}: {}.{} is quantised and is left out", file_.string(), what, name));
      if (!plain || !accessor.contains("bufferView") || accessor.value("count", std::uint64_t{0}) != vertices) break;
      kept[name] = attributes[name];
    }
    if (poses_) {
      for (const auto& [name, accessor] : attributes.items()) {
        if (name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_")) kept[name] = accessor;
      }
    }
    primitive["attributes"] = std::move(kept);
    return vertices > 0;
  }

  void checkNodes() {
    Json& nodes = list("nodes");
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      Json& node = nodes[i];
      const std::string what = fmt::format("nodes[{}]", i);
      for (const char* key : {"camera", "extensions", "extras"}) node.erase(key);
      if (!poses_) {
        for (const char* key : {"skin", "weights"}) node.erase(key);
      }
      if (node.contains("mesh")) {
        const Json& mesh = list("meshes")[index(node["mesh"], list("meshes").size(), what + ".mesh")];
        if (mesh["primitives"].empty()) node.erase("mesh");
      }
      for (const auto& [key, size] : {std::pair{"matrix", 16u}, {"translation", 3u}, {"rotation", 4u}, {"scale", 3u}}) {
        if (!node.contains(key)) continue;
        const bool numbers = node[key].is_array() && std::all_of(node[key].begin(), node[key].end(),
                                                                 [](const Json& n) { return n.is_number(); });
        if (!numbers || node[key].size() != size) fail(fmt::format("{}.{} is not {} numbers", what, key, size));
      }
      if (node.contains("children") && !node["children"].is_array()) fail(what + ".children is not a list");
    }
    checkTree();
  }

  // Every node is reached at most once from the scene: no cycles, no shared children.
  void checkTree() {
    const Json& nodes = list("nodes");
    Json& scenes = list("scenes");
    if (scenes.empty()) fail("has no scene: export it with its nodes in a scene");
    const std::size_t scene = json_.contains("scene") ? index(json_["scene"], scenes.size(), "scene") : std::size_t{0};
    json_["scene"] = scene;
    struct Item {
      std::size_t node;
      int depth;
    };
    std::vector<Item> open;
    std::vector<bool> seen(nodes.size(), false);
    const auto add = [&](const Json& children, int depth) {
      for (const Json& child : children) open.push_back({index(child, nodes.size(), "a child of a node"), depth});
    };
    for (const Json& each : scenes) {
      std::fill(seen.begin(), seen.end(), false);
      if (each.contains("nodes")) add(each["nodes"], 1);
      while (!open.empty()) {
        const Item item = open.back();
        open.pop_back();
        if (seen[item.node]) fail(fmt::format("nodes[{}] has two parents, or is its own ancestor", item.node));
        if (item.depth > kMaxDepth) fail(fmt::format("has nodes nested over {} deep", kMaxDepth));
        seen[item.node] = true;
        if (nodes[item.node].contains("children")) add(nodes[item.node]["children"], item.depth + 1);
      }
    }
  }

  std::filesystem::path file_;
  GltfContainer container_;
  Json json_;
  bool poses_ = false;
};

template <class Ask>
auto ofAnimations(const std::filesystem::path& file, const Ask& ask) {
  const GltfContainer checked = Checker(file).run(true);
  try {
    GltfData data(checked, file);
    return ask(data);
  } catch (const Json::exception& e) {
    throw InputError({file.string()}, fmt::format("is not valid glTF: {}", e.what()));
  }
}

}  // namespace

std::string checkedGltf(const std::filesystem::path& file, const std::optional<ClipTime>& clip) {
  Checker checker(file);
  GltfContainer checked = checker.run(clip.has_value());
  if (checker.poses()) checked = posedGltf(std::move(checked), file, clip);
  return packGltf(std::move(checked), file);
}

std::pair<double, double> clipSpan(const std::filesystem::path& file, const std::string& clip) {
  return ofAnimations(file, [&](GltfData& data) { return data.spanOf(data.clip(clip)); });
}

std::vector<GltfClip> gltfClips(const std::filesystem::path& file) {
  return ofAnimations(file, [](GltfData& data) {
    std::vector<GltfClip> clips;
    for (const std::string& name : data.clips()) {
      const auto [first, last] = data.spanOf(clips.size());
      clips.push_back({name, first, last});
    }
    return clips;
  });
}

std::string decodeUri(std::string_view uri) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
  };
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      out += static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
      i += 2;
    } else {
      out += uri[i];
    }
  }
  return out;
}

}  // namespace scanmill
