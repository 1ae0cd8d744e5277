#include "assets/meshes/gltf/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "assets/meshes/gltf/json_reader.h"
#include "assets/meshes/references.h"
#include "base/error.h"

namespace scanmill::gltf {
namespace {

constexpr int kMostLevels = 512;  // of nodes below each other

// True for extensions that only affect appearance. Transmissions are counted by material.
bool isAppearance(std::string_view extension) {
  return extension.starts_with("KHR_materials_") || extension.starts_with("KHR_technique") ||
         extension.starts_with("EXT_lights_");
}

class ModelReader : JsonReader {
 public:
  ModelReader(Model& model, const Json& json, bool allowOutside)
      : JsonReader(model, json), allowOutside_(allowOutside) {}

  void read() {
    if (!json_.is_object()) fail("is not valid glTF: the file is not a JSON object");
    const auto asset = json_.find("asset");
    if (asset == json_.end() || !asset->is_object()) fail("is not glTF: 'asset' is missing");
    const std::string version = asset->value("version", std::string());
    if (!version.starts_with("2.")) {
      fail(fmt::format("is glTF {}: only version 2.0 is read, so export it again",
                       version.empty() ? "of no version" : version));
    }
    for (const Json& name : list("extensionsRequired")) {
      const auto extension = name.get<std::string>();
      if (isAppearance(extension) || gltfFormat().find(extension) != nullptr) continue;
      fail(fmt::format("requires the extension {}, which is not supported: export it without this extension",
                       extension));
    }
    for (const Json& name : list("extensionsUsed")) {
      if (!isAppearance(name.get<std::string>())) model_.leftOut.addKeyword(gltfFormat(), name.get<std::string>());
    }
    if (const auto extensions = json_.find("extensions"); extensions != json_.end() && extensions->is_object()) {
      if (const auto rtc = extensions->find("CESIUM_RTC"); rtc != extensions->end()) {
        const auto [x, y, z] = rtc->at("center").get<std::array<double, 3>>();
        model_.center = Vec3d{x, y, z};
      }
    }
    readStorage(model_, json_, allowOutside_);
    each("images", model_.images, [&](const Json& json, const std::string& path) { return readImage(json, path); });
    each("materials", model_.materials,
         [&](const Json& json, const std::string& path) { return readMaterial(json, path); });
    each("meshes", model_.meshes, [&](const Json& json, const std::string& path) { return readMesh(json, path); });
    each("skins", model_.skins, [&](const Json& json, const std::string& path) { return readSkin(json, path); });
    each("nodes", model_.nodes, [&](const Json& json, const std::string& path) { return readNode(json, path); });
    each("animations", model_.animations,
         [&](const Json& json, const std::string& path) { return readAnimation(json, path); });
    readScene();
    checkTree();
  }

 private:
  Attributes readAttributes(const Json& object, const std::string& path) const {
    Attributes attributes;
    for (const auto& [name, value] : object.items()) {
      attributes[name] = readIndex(value, model_.accessors.size(), path + "." + name);
    }
    return attributes;
  }

  // Counts the colours and the values with names of their own, such as _BATCHID, of "vertices" or "instances".
  void countUnread(const Attributes& attributes, const char* owners) const {
    for (const auto& [name, accessor] : attributes) {
      const bool isColor = name.starts_with("COLOR_");
      if (!isColor && !name.starts_with('_')) continue;
      model_.leftOut.add(fmt::format("{} of {} ({})", isColor ? "colours" : "values", owners, name.substr(0, 40)),
                         model_.accessors[accessor].count);
    }
  }

  Image readImage(const Json& json, const std::string& path) const {
    Image image{.name = json.value("name", std::string()),
                .view = readOptionalIndex(json, "bufferView", model_.views.size(), path)};
    if (json.contains("uri")) {
      image.uri = json["uri"].get<std::string>();
      if (!image.uri.starts_with("data:")) image.uri = decodeUri(image.uri);
    }
    return image;
  }

  // Returns the image of a texture, which may be in an extension; nullopt if the texture names no image.
  MaybeIndex imageOf(Index texture) const {
    const Json& json = list("textures")[texture];
    const std::string path = fmt::format("textures[{}]", texture);
    if (const MaybeIndex source = readOptionalIndex(json, "source", model_.images.size(), path)) return source;
    for (const char* name : {"EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"}) {
      if (const Json* extension = extensionOf(json, name)) {
        if (const MaybeIndex source = readOptionalIndex(*extension, "source", model_.images.size(), path))
          return source;
      }
    }
    return std::nullopt;
  }

  // False if the sampler of a texture clamps or mirrors it.
  bool repeats(Index texture) const {
    constexpr int kRepeat = 10497;  // of OpenGL, as in glTF
    const MaybeIndex sampler = readOptionalIndex(list("textures")[texture], "sampler", list("samplers").size(),
                                                 fmt::format("textures[{}]", texture));
    if (!sampler) return true;
    const Json& json = list("samplers")[*sampler];
    return json.value("wrapS", kRepeat) == kRepeat && json.value("wrapT", kRepeat) == kRepeat;
  }

  // Returns how a material uses the texture under a key; nullopt if it names no image.
  std::optional<TextureUse> textureUse(const Json& material, const char* key, const std::string& materialPath) const {
    const auto json = material.find(key);
    if (json == material.end()) return std::nullopt;
    const std::string path = materialPath + "." + key;
    const Index texture = readIndex(json->at("index"), list("textures").size(), path);
    const MaybeIndex image = imageOf(texture);
    if (!image) return std::nullopt;
    const Json* const transform = extensionOf(*json, "KHR_texture_transform");
    std::uint64_t coordinates = readLength(*json, "texCoord", 0, path);
    TextureUse use{.image = *image, .repeats = repeats(texture)};
    if (transform != nullptr) {
      readNumbers(*transform, "offset", path, use.offset);
      readNumbers(*transform, "scale", path, use.scale);
      use.rotation = transform->value("rotation", 0.0);
      coordinates = readLength(*transform, "texCoord", coordinates, path);
    }
    constexpr std::uint64_t kMostCoordinates = 1000;  // more than any file has
    use.coordinates = static_cast<unsigned>(std::min(coordinates, kMostCoordinates));
    return use;
  }

  Material readMaterial(const Json& json, const std::string& path) const {
    Material material{.name = json.value("name", std::string())};
    if (const Json* specularGlossiness = extensionOf(json, "KHR_materials_pbrSpecularGlossiness")) {
      readNumbers(*specularGlossiness, "diffuseFactor", path, material.color);
      material.texture = textureUse(*specularGlossiness, "diffuseTexture", path);
      material.metallic = 0;
      material.roughness = 1 - specularGlossiness->value("glossinessFactor", 1.0);
    } else if (const Json* metallicRoughness = objectIn(json, "pbrMetallicRoughness")) {
      readNumbers(*metallicRoughness, "baseColorFactor", path, material.color);
      material.texture = textureUse(*metallicRoughness, "baseColorTexture", path);
      material.metallic = metallicRoughness->value("metallicFactor", 1.0);
      material.roughness = metallicRoughness->value("roughnessFactor", 1.0);
    }
    const Json* const transmission = extensionOf(json, "KHR_materials_transmission");
    if (transmission != nullptr && transmission->value("transmissionFactor", 0.0) > 0) {
      material.leftOut.add("transmissions of materials (they are solid)");
    }
    if (!material.texture && std::max({material.color[0], material.color[1], material.color[2]}) == 0 &&
        json.contains("emissiveTexture")) {
      material.leftOut.add("emissive images of materials with a black base colour");
    }
    const std::string mode = json.value("alphaMode", std::string("OPAQUE"));
    material.alpha = mode == "MASK"    ? Material::Alpha::Mask
                     : mode == "BLEND" ? Material::Alpha::Blend
                                       : Material::Alpha::Opaque;
    material.cutoff = json.value("alphaCutoff", 0.5);
    return material;
  }

  Mesh readMesh(const Json& json, const std::string& path) const {
    Mesh mesh{.name = json.value("name", std::string())};
    if (json.contains("weights")) mesh.weights = json["weights"].get<std::vector<double>>();
    const Json& primitives = json.at("primitives");
    if (!primitives.is_array()) fail(path + ".primitives is not a list");
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const std::string primitivePath = fmt::format("{}.primitives[{}]", path, i);
      constexpr std::uint64_t kPoints = 0, kTriangles = 4, kLastMode = 6;  // those between are of lines
      const std::uint64_t mode = readLength(primitives[i], "mode", kTriangles, primitivePath);
      if (mode > kLastMode) fail(primitivePath + " has an unknown mode");
      if (mode < kTriangles) {
        model_.leftOut.add(mode == kPoints ? "primitives of points" : "primitives of lines");
        continue;
      }
      Primitive primitive = readPrimitive(primitives[i], primitivePath);
      primitive.mode = static_cast<Primitive::Mode>(mode);
      countUnread(primitive.attributes, "vertices");
      if (primitive.attributes.contains("POSITION")) {
        mesh.primitives.push_back(std::move(primitive));
      } else {
        model_.leftOut.add("primitives without positions");
      }
    }
    return mesh;
  }

  Primitive readPrimitive(const Json& json, const std::string& path) const {
    Primitive primitive;
    primitive.material = readOptionalIndex(json, "material", model_.materials.size(), path);
    if (!json.contains("attributes") || !json["attributes"].is_object()) return primitive;
    primitive.attributes = readAttributes(json["attributes"], path);
    primitive.indices = readOptionalIndex(json, "indices", model_.accessors.size(), path);
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return primitive;
    const Accessor& positions = model_.accessors[position->second];
    if (positions.width != 3) fail(path + " has positions that do not have 3 numbers");
    if (const Json* draco = extensionOf(json, "KHR_draco_mesh_compression")) {
      primitive.draco = Primitive::Draco{};
      primitive.draco->view = readIndex(draco->at("bufferView"), model_.views.size(), path + ".bufferView");
      for (const auto& [name, id] : draco->at("attributes").items()) {
        primitive.draco->attributes[name] = static_cast<std::uint32_t>(readIndex(id, UINT32_MAX, path + "." + name));
      }
      if (!primitive.draco->attributes.contains("POSITION")) {
        fail(fmt::format("is not valid glTF: {} has no compressed positions", path));
      }
    } else if (primitive.indices) {
      const Accessor& indices = model_.accessors[*primitive.indices];
      if (indices.width != 1) fail(path + " has indices that are not single numbers");
      if (!indices.view && !indices.sparse && indices.count > 0) fail(path + " has indices without data");
    }
    for (const Json& target : listIn(json, "targets", path + ".targets"))
      primitive.targets.push_back(readAttributes(target, path));
    return primitive;
  }

  Skin readSkin(const Json& json, const std::string& path) const {
    Skin skin;
    const std::size_t nodes = list("nodes").size();
    for (const Json& joint : json.at("joints")) skin.joints.push_back(readIndex(joint, nodes, path + ".joints"));
    skin.inverseBindMatrices = readOptionalIndex(json, "inverseBindMatrices", model_.accessors.size(), path);
    if (skin.inverseBindMatrices) {
      const Accessor& matrices = model_.accessors[*skin.inverseBindMatrices];
      if (matrices.width != 16 || matrices.count < skin.joints.size()) {
        fail(fmt::format("is not valid glTF: {} has fewer matrices than joints", path));
      }
    }
    return skin;
  }

  Node readNode(const Json& json, const std::string& path) const {
    Node node{.name = json.value("name", std::string())};
    const std::size_t nodes = list("nodes").size();
    for (const Json& child : listIn(json, "children", path + ".children")) {
      node.children.push_back(readIndex(child, nodes, "a child of a node"));
    }
    node.mesh = readOptionalIndex(json, "mesh", model_.meshes.size(), path);
    node.skin = readOptionalIndex(json, "skin", model_.skins.size(), path);
    if (json.contains("weights")) node.weights = json["weights"].get<std::vector<double>>();
    std::array<double, 16> matrix{};
    if (readNumbers(json, "matrix", path, matrix)) node.matrix = matrix;
    readNumbers(json, "translation", path, node.translation);
    readNumbers(json, "rotation", path, node.rotation);
    readNumbers(json, "scale", path, node.scale);
    if (const Json* visibility = extensionOf(json, "KHR_node_visibility"))
      node.visible = visibility->value("visible", true);
    if (const Json* instancing = extensionOf(json, "EXT_mesh_gpu_instancing")) {
      const std::string extensionPath = path + ".EXT_mesh_gpu_instancing";
      node.instances = readAttributes(instancing->at("attributes"), extensionPath);
      countUnread(*node.instances, "instances");
      const auto first = node.instances->begin();
      for (const auto& [name, accessor] : *node.instances) {
        if (model_.accessors[accessor].count != model_.accessors[first->second].count) {
          fail(fmt::format("is not valid glTF: {} has {} values of {}, but {} of {}", extensionPath,
                           model_.accessors[first->second].count, first->first, model_.accessors[accessor].count,
                           name));
        }
      }
    }
    return node;
  }

  Animation readAnimation(const Json& json, const std::string& path) const {
    Animation animation{.name = json.value("name", std::string())};
    for (const Json& samplerJson : json.at("samplers")) {
      Animation::Sampler sampler;
      sampler.input = readIndex(samplerJson.at("input"), model_.accessors.size(), path + ".input");
      sampler.output = readIndex(samplerJson.at("output"), model_.accessors.size(), path + ".output");
      const std::string interpolation = samplerJson.value("interpolation", std::string("LINEAR"));
      sampler.interpolation = interpolation == "STEP"          ? Animation::Interpolation::Step
                              : interpolation == "CUBICSPLINE" ? Animation::Interpolation::CubicSpline
                                                               : Animation::Interpolation::Linear;
      animation.samplers.push_back(sampler);
    }
    for (const Json& channelJson : json.at("channels")) {
      using Path = Animation::Path;
      static const std::map<std::string, Path> kPaths{{"translation", Path::Translation},
                                                      {"rotation", Path::Rotation},
                                                      {"scale", Path::Scale},
                                                      {"weights", Path::Weights}};
      Animation::Channel channel;
      channel.sampler = readIndex(channelJson.at("sampler"), animation.samplers.size(), path + ": a channel's sampler");
      const Json& target = channelJson.at("target");
      const auto property = target.at("path").get<std::string>();
      animation.pointers += property == "pointer" ? 1 : 0;
      if (!kPaths.contains(property) || !target.contains("node")) continue;  // skips channels with other targets
      channel.path = kPaths.at(property);
      channel.node = readIndex(target["node"], model_.nodes.size(), path + "'s target");
      animation.channels.push_back(channel);
    }
    return animation;
  }

  // Reads the roots of the default scene or, if the file names none, of the first scene. In a file without scenes all
  // nodes are roots that are no children.
  void readScene() {
    const Json& scenes = list("scenes");
    if (scenes.empty()) {
      std::vector<bool> isChild(model_.nodes.size(), false);
      for (const Node& node : model_.nodes) {
        for (const Index child : node.children) isChild[child] = true;
      }
      for (Index i = 0; i < model_.nodes.size(); ++i) {
        if (!isChild[i]) model_.roots.push_back(i);
      }
    } else {
      const MaybeIndex scene = readOptionalIndex(json_, "scene", scenes.size(), "the file");
      for (const Json& root : listIn(scenes[scene.value_or(0)], "nodes", "nodes of a scene")) {
        model_.roots.push_back(readIndex(root, model_.nodes.size(), "a node of the scene"));
      }
    }
  }

  // Throws unless the scene reaches each of its nodes only once. Counts meshes that it does not reach.
  void checkTree() const {
    std::vector<std::pair<Index, int>> pending;  // nodes and their depths
    for (const Index root : model_.roots) pending.emplace_back(root, 1);
    std::vector<bool> isReached(model_.nodes.size(), false);
    while (!pending.empty()) {
      const auto [node, depth] = pending.back();
      pending.pop_back();
      if (isReached[node]) fail(fmt::format("nodes[{}] has two parents, or is its own ancestor", node));
      if (depth > kMostLevels) fail(fmt::format("has nodes that are nested more than {} levels deep", kMostLevels));
      isReached[node] = true;
      for (const Index child : model_.nodes[node].children) pending.emplace_back(child, depth + 1);
    }
    for (Index i = 0; i < model_.nodes.size(); ++i) {
      if (!isReached[i] && model_.nodes[i].mesh) model_.leftOut.add("nodes outside of the scene");
    }
  }

  bool allowOutside_;
};

}  // namespace

const FormatSupport& gltfFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "glTF",
      ".gltf, .glb, .b3dm",
      {{Read, "KHR_mesh_quantization EXT_meshopt_compression KHR_meshopt_compression KHR_draco_mesh_compression"},
       {Read, "EXT_mesh_gpu_instancing KHR_node_visibility CESIUM_RTC KHR_texture_transform EXT_texture_webp"},
       {Read, "EXT_texture_avif KHR_texture_basisu MSFT_texture_dds"},
       {Unused, "KHR_lights_punctual KHR_xmp_json_ld KHR_xmp FB_ngon_encoding CESIUM_primitive_outline"},
       {Unused, "GODOT_single_root OMI_physics_body OMI_physics_shape KHR_physics_rigid_bodies KHR_implicit_shapes"},
       {Unused, "KHR_animation_pointer"},
       {LeftOut, "MSFT_lod", "levels of detail (MSFT_lod; the nodes of the scene are read, coarser ones too)"}},
      "The default scene, else the first, else all nodes; a node without a name is named by its nearest ancestor with "
      "one, else by its mesh. Triangles, strips and fans; skins and morph targets in the file's pose, or in the pose "
      "at a time of an animation. Colours are linear light, as the specification says; the key `alpha` says where "
      "beams pass an image. An image that cannot be decoded is warned of. Lights, physics and KHR_materials_* change "
      "nothing",
      "transmissions, opacities and images that fade, of materials, which are solid; emissive images of materials with "
      "a black base colour; colours of vertices; values of vertices and instances, such as _BATCHID; points and lines; "
      "hidden nodes; nodes outside of the scene; batch tables (.b3dm); clamped or mirrored textures, which repeat; "
      "textures of parts without texture coordinates; channels of animations by pointers (KHR_animation_pointer)"};
  return format;
}

void Model::fail(const std::string& problem) const {
  throw InputError({file.string()}, problem);
}

Model readModel(const std::filesystem::path& file, const std::filesystem::path& name, bool allowOutside) {
  Container container = readContainer(file, name);
  Model model;
  model.file = name;
  model.bin = std::move(container.bin);
  model.center = container.center;
  if (container.batchTable) model.leftOut.add("batch tables (.b3dm)");
  try {
    const Json json = Json::parse(container.json);
    ModelReader(model, json, allowOutside).read();
  } catch (const Json::exception& e) {
    model.fail(fmt::format("is not valid glTF: {}", reasonOf(e)));
  }
  return model;
}

}  // namespace scanmill::gltf
