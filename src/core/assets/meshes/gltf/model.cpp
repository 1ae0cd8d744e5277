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

constexpr int kMostLevels = 512;  // largest depth of nested nodes

// True for extensions that only affect appearance and need no warning. Transmission is counted when materials are read.
bool isAppearance(std::string_view extension) {
  return extension.starts_with("KHR_materials_") || extension.starts_with("KHR_technique") ||
         extension.starts_with("EXT_lights_");
}

class ModelReader {
 public:
  // `json`: the JSON of the file.
  ModelReader(Model& model, const Json& json, bool allowOutside)
      : model_(model), file_{model, json, ""}, allowOutside_(allowOutside) {}

  void read() {
    if (!file_.json.is_object()) model_.fail("is not valid glTF: the file is not a JSON object");
    checkVersionAndExtensions();
    if (const auto extensions = file_.json.find("extensions");
        extensions != file_.json.end() && extensions->contains("CESIUM_RTC")) {
      const auto [x, y, z] = extensions->at("CESIUM_RTC").at("center").get<std::array<double, 3>>();
      model_.center = Vec3d{x, y, z};
    }
    readStorage(model_, file_, allowOutside_);
    readEach(file_, "images", model_.images, [&](const JsonObject& json) { return readImage(json); });
    readEach(file_, "materials", model_.materials, [&](const JsonObject& json) { return readMaterial(json); });
    readEach(file_, "meshes", model_.meshes, [&](const JsonObject& json) { return readMesh(json); });
    readEach(file_, "skins", model_.skins, [&](const JsonObject& json) { return readSkin(json); });
    readEach(file_, "nodes", model_.nodes, [&](const JsonObject& json) { return readNode(json); });
    readEach(file_, "animations", model_.animations, [&](const JsonObject& json) { return readAnimation(json); });
    readScene();
    checkTree();
  }

 private:
  void checkVersionAndExtensions() const {
    const auto asset = file_.json.find("asset");
    if (asset == file_.json.end() || !asset->is_object()) model_.fail("is not glTF: 'asset' is missing");
    const std::string version = asset->value("version", std::string());
    if (!version.starts_with("2.")) {
      model_.fail("is glTF {}: only version 2.0 is read, so export it again",
                  version.empty() ? "of no version" : version);
    }
    for (const Json& name : file_.list("extensionsRequired")) {
      const auto extension = name.get<std::string>();
      if (isAppearance(extension) || kGltfFormat.useOf(extension) != FormatSupport::Use::Unknown) continue;
      model_.fail("requires the extension {}, which is not supported: export it without this extension", extension);
    }
    for (const Json& name : file_.list("extensionsUsed")) {
      if (!isAppearance(name.get<std::string>())) model_.leftOut.addKeyword(kGltfFormat, name.get<std::string>());
    }
  }

  // Reads an object whose keys are names of attributes. `path`: the path of the primitive or node that contains it.
  Attributes readAttributes(const Json& object, const std::string& path) const {
    Attributes attributes;
    for (const auto& [name, value] : object.items()) {
      attributes[name] = file_.index(value, model_.accessors.size(), path + "." + name);
    }
    return attributes;
  }

  // Counts unread attributes, which are colours and custom ones such as _BATCHID. `owners`: "vertices" or "instances".
  void countUnread(const Attributes& attributes, const char* owners) const {
    for (const auto& [name, accessor] : attributes) {
      const bool isColor = name.starts_with("COLOR_");
      if (!isColor && !name.starts_with('_')) continue;
      model_.leftOut.add(fmt::format("{} of {} ({})", isColor ? "colours" : "values", owners, name.substr(0, 40)),
                         model_.accessors[accessor].count);
    }
  }

  Image readImage(const JsonObject& object) const {
    Image image{.name = object.json.value("name", std::string()),
                .uri = object.json.value("uri", std::string()),
                .view = object.maybeIndex("bufferView", model_.views.size())};
    if (!image.uri.starts_with("data:")) image.uri = decodeUri(image.uri);
    return image;
  }

  // Returns the index of a texture's image, which an extension may name; nullopt if no image is named.
  MaybeIndex imageOf(const JsonObject& texture) const {
    const std::size_t images = model_.images.size();
    if (const MaybeIndex source = texture.maybeIndex("source", images)) return source;
    for (const char* name : {"EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"}) {
      const auto extension = texture.extension(name);
      const MaybeIndex source = extension ? extension->maybeIndex("source", images) : std::nullopt;
      if (source) return source;
    }
    return std::nullopt;
  }

  // False if the sampler of a texture clamps or mirrors it.
  bool repeats(const JsonObject& texture) const {
    constexpr int kRepeat = 10497;  // glTF's code for repeating, which is OpenGL's
    const Json& samplers = file_.list("samplers");
    const MaybeIndex sampler = texture.maybeIndex("sampler", samplers.size());
    return !sampler || (samplers[*sampler].value("wrapS", kRepeat) == kRepeat &&
                        samplers[*sampler].value("wrapT", kRepeat) == kRepeat);
  }

  // Returns how a material uses the texture under a key; nullopt if the key is absent or the texture names no image.
  std::optional<TextureUse> textureUse(const JsonObject& material, const char* key) const {
    if (!material.json.contains(key)) return std::nullopt;
    const JsonObject object{model_, material.json[key], material.pathOf(key)};
    const Json& textures = file_.list("textures");
    const Index index = file_.index(object.json.at("index"), textures.size(), object.path);
    const JsonObject texture{model_, textures[index], fmt::format("textures[{}]", index)};
    const MaybeIndex image = imageOf(texture);
    if (!image) return std::nullopt;
    TextureUse use{.image = *image, .repeats = repeats(texture)};
    std::uint64_t coordinates = object.length("texCoord");
    if (const auto transform = object.extension("KHR_texture_transform")) {
      transform->numbers("offset", use.offset);
      transform->numbers("scale", use.scale);
      use.rotation = transform->json.value("rotation", 0.0);
      coordinates = transform->length("texCoord", coordinates);
    }
    constexpr std::uint64_t kMostCoordinates = 1000;  // more than any file has
    use.coordinates = static_cast<unsigned>(std::min(coordinates, kMostCoordinates));
    return use;
  }

  Material readMaterial(const JsonObject& object) const {
    const Json& json = object.json;
    Material material{.name = json.value("name", std::string())};
    if (const auto specularGlossiness = object.extension("KHR_materials_pbrSpecularGlossiness")) {
      specularGlossiness->numbers("diffuseFactor", material.color);
      material.texture = textureUse(*specularGlossiness, "diffuseTexture");
      material.metallic = 0;
      material.roughness = 1 - specularGlossiness->json.value("glossinessFactor", 1.0);
    } else if (const auto metallicRoughness = object.object("pbrMetallicRoughness")) {
      metallicRoughness->numbers("baseColorFactor", material.color);
      material.texture = textureUse(*metallicRoughness, "baseColorTexture");
      material.metallic = metallicRoughness->json.value("metallicFactor", 1.0);
      material.roughness = metallicRoughness->json.value("roughnessFactor", 1.0);
    }
    const auto transmission = object.extension("KHR_materials_transmission");
    if (transmission && transmission->json.value("transmissionFactor", 0.0) > 0) {
      material.leftOut.add("transmissions of materials (they are solid)");
    }
    const bool isBlack = std::max({material.color[0], material.color[1], material.color[2]}) == 0;
    if (!material.texture && isBlack && json.contains("emissiveTexture")) {
      material.leftOut.add("emissive images of materials with a black base colour");
    }
    const std::string mode = json.value("alphaMode", std::string("OPAQUE"));
    material.alpha = mode == "MASK"    ? Material::Alpha::Mask
                     : mode == "BLEND" ? Material::Alpha::Blend
                                       : Material::Alpha::Opaque;
    material.cutoff = json.value("alphaCutoff", 0.5);
    return material;
  }

  Mesh readMesh(const JsonObject& object) const {
    Mesh mesh{.name = object.json.value("name", std::string()),
              .weights = object.json.value("weights", std::vector<double>())};
    const Json& primitives = object.json.at("primitives");
    if (!primitives.is_array()) model_.fail("{}.primitives is not a list", object.path);
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const JsonObject primitiveObject{model_, primitives[i], fmt::format("{}.primitives[{}]", object.path, i)};
      constexpr std::uint64_t kPoints = 0, kTriangles = 4, kLastMode = 6;  // modes 1 to 3 are lines
      const std::uint64_t mode = primitiveObject.length("mode", kTriangles);
      if (mode > kLastMode) primitiveObject.fail("has an unknown mode");
      if (mode < kTriangles) {
        model_.leftOut.add(mode == kPoints ? "primitives of points" : "primitives of lines");
        continue;
      }
      Primitive primitive = readPrimitive(primitiveObject);
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

  // Reads a primitive, except its mode. Without positions, reads only the material, the attributes and the indices.
  Primitive readPrimitive(const JsonObject& object) const {
    Primitive primitive;
    primitive.material = object.maybeIndex("material", model_.materials.size());
    if (!object.json.contains("attributes") || !object.json["attributes"].is_object()) return primitive;
    primitive.attributes = readAttributes(object.json["attributes"], object.path);
    primitive.indices = object.maybeIndex("indices", model_.accessors.size());
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return primitive;
    if (model_.accessors[position->second].width != 3) object.fail("has positions that do not have 3 numbers");
    if (const auto draco = object.extension("KHR_draco_mesh_compression")) {
      primitive.draco = Primitive::Draco{.view = draco->index("bufferView", model_.views.size())};
      for (const auto& [name, id] : draco->json.at("attributes").items()) {
        primitive.draco->attributes[name] =
            static_cast<std::uint32_t>(draco->index(id, UINT32_MAX, draco->path + "." + name));
      }
      if (!primitive.draco->attributes.contains("POSITION")) object.failInvalid("has no compressed positions");
    } else if (primitive.indices) {
      const Accessor& indices = model_.accessors[*primitive.indices];
      if (indices.width != 1) object.fail("has indices that are not single numbers");
      if (!indices.view && !indices.sparse && indices.count > 0) object.fail("has indices without data");
    }
    for (const Json& target : object.list("targets")) primitive.targets.push_back(readAttributes(target, object.path));
    return primitive;
  }

  Skin readSkin(const JsonObject& object) const {
    Skin skin;
    const std::size_t nodes = file_.list("nodes").size();
    for (const Json& joint : object.json.at("joints")) {
      skin.joints.push_back(object.index(joint, nodes, object.pathOf("joints")));
    }
    skin.inverseBindMatrices = object.maybeIndex("inverseBindMatrices", model_.accessors.size());
    if (!skin.inverseBindMatrices) return skin;
    const Accessor& matrices = model_.accessors[*skin.inverseBindMatrices];
    if (matrices.width != 16 || matrices.count < skin.joints.size())
      object.failInvalid("has fewer matrices than joints");
    return skin;
  }

  Node readNode(const JsonObject& object) const {
    Node node{.name = object.json.value("name", std::string()),
              .mesh = object.maybeIndex("mesh", model_.meshes.size()),
              .skin = object.maybeIndex("skin", model_.skins.size()),
              .weights = object.json.value("weights", std::vector<double>())};
    const std::size_t nodes = file_.list("nodes").size();
    for (const Json& child : object.list("children")) {
      node.children.push_back(object.index(child, nodes, "a child of a node"));
    }
    std::array<double, 16> matrix{};
    if (object.numbers("matrix", matrix)) node.matrix = matrix;
    object.numbers("translation", node.translation);
    object.numbers("rotation", node.rotation);
    object.numbers("scale", node.scale);
    const auto visibility = object.extension("KHR_node_visibility");
    if (visibility) node.visible = visibility->json.value("visible", true);
    if (const auto instancing = object.extension("EXT_mesh_gpu_instancing")) {
      const std::string path = object.pathOf("EXT_mesh_gpu_instancing");
      node.instances = readAttributes(instancing->json.at("attributes"), path);
      countUnread(*node.instances, "instances");
      for (const auto& [name, accessor] : *node.instances) {
        const auto& [firstName, firstAccessor] = *node.instances->begin();
        const std::uint64_t count = model_.accessors[accessor].count,
                            firstCount = model_.accessors[firstAccessor].count;
        if (count == firstCount) continue;
        model_.fail("is not valid glTF: {} has {} values of {}, but {} of {}", path, firstCount, firstName, count,
                    name);
      }
    }
    return node;
  }

  Animation readAnimation(const JsonObject& object) const {
    Animation animation{.name = object.json.value("name", std::string())};
    for (const Json& json : object.json.at("samplers")) {
      const JsonObject samplerObject{model_, json, object.path};
      const std::string interpolation = json.value("interpolation", std::string("LINEAR"));
      animation.samplers.push_back({.input = samplerObject.index("input", model_.accessors.size()),
                                    .output = samplerObject.index("output", model_.accessors.size()),
                                    .interpolation = interpolation == "STEP" ? Animation::Interpolation::Step
                                                     : interpolation == "CUBICSPLINE"
                                                         ? Animation::Interpolation::CubicSpline
                                                         : Animation::Interpolation::Linear});
    }
    for (const Json& json : object.json.at("channels")) {
      using Path = Animation::Path;
      static const std::map<std::string, Path> kPaths{{"translation", Path::Translation},
                                                      {"rotation", Path::Rotation},
                                                      {"scale", Path::Scale},
                                                      {"weights", Path::Weights}};
      const Index sampler =
          object.index(json.at("sampler"), animation.samplers.size(), object.path + ": a channel's sampler");
      const Json& target = json.at("target");
      const auto property = target.at("path").get<std::string>();
      animation.pointers += property == "pointer" ? 1 : 0;
      if (!kPaths.contains(property) || !target.contains("node")) continue;  // skips channels with other targets
      const Index node = object.index(target["node"], model_.nodes.size(), object.path + "'s target");
      animation.channels.push_back({.sampler = sampler, .node = node, .path = kPaths.at(property)});
    }
    return animation;
  }

  // Reads the roots of the default scene or, if the file names none, of the first scene. In a file without scenes, all
  // nodes that are not children are roots.
  void readScene() {
    const Json& scenes = file_.list("scenes");
    if (scenes.empty()) {
      std::vector<bool> isChild(model_.nodes.size(), false);
      for (const Node& node : model_.nodes) {
        for (const Index child : node.children) isChild[child] = true;
      }
      for (Index i = 0; i < model_.nodes.size(); ++i) {
        if (!isChild[i]) model_.roots.push_back(i);
      }
      return;
    }
    Index scene = 0;
    if (file_.json.contains("scene")) scene = file_.index(file_.json["scene"], scenes.size(), "the file.scene");
    for (const Json& root : JsonObject{model_, scenes[scene], ""}.list("nodes", "nodes of a scene")) {
      model_.roots.push_back(file_.index(root, model_.nodes.size(), "a node of the scene"));
    }
  }

  // Throws if a node has two parents or is its own ancestor. Counts nodes with meshes that are outside of the scene.
  void checkTree() const {
    std::vector<std::pair<Index, int>> pending;  // nodes and their depths
    for (const Index root : model_.roots) pending.emplace_back(root, 1);
    std::vector<bool> isReached(model_.nodes.size(), false);
    while (!pending.empty()) {
      const auto [node, depth] = pending.back();
      pending.pop_back();
      if (isReached[node]) model_.fail("nodes[{}] has two parents, or is its own ancestor", node);
      if (depth > kMostLevels) model_.fail("has nodes that are nested more than {} levels deep", kMostLevels);
      isReached[node] = true;
      for (const Index child : model_.nodes[node].children) pending.emplace_back(child, depth + 1);
    }
    for (Index i = 0; i < model_.nodes.size(); ++i) {
      if (!isReached[i] && model_.nodes[i].mesh) model_.leftOut.add("nodes outside of the scene");
    }
  }

  Model& model_;
  JsonObject file_;
  bool allowOutside_;
};

}  // namespace

const FormatSupport kGltfFormat{
    "glTF",
    ".gltf, .glb, .b3dm",
    "The default scene, else the first, else all nodes; a node without a name is named by its nearest ancestor with "
    "one, else by its mesh. Triangles, strips and fans; skins and morph targets in the file's pose, or in the pose "
    "at a time of an animation. Colours are linear light, as the specification says; the key `alpha` says where "
    "beams pass an image. An image that cannot be decoded is warned of. Lights, physics and KHR_materials_* change "
    "nothing",
    "transmissions, opacities and images that fade, of materials, which are solid; emissive images of materials with "
    "a black base colour; colours of vertices; values of vertices and instances, such as _BATCHID; points and lines; "
    "hidden nodes; nodes outside of the scene; batch tables (.b3dm); clamped or mirrored textures, which repeat; "
    "textures of parts without texture coordinates; channels of animations by pointers (KHR_animation_pointer)",
    {.read = {"KHR_mesh_quantization EXT_meshopt_compression KHR_meshopt_compression KHR_draco_mesh_compression",
              "EXT_mesh_gpu_instancing KHR_node_visibility CESIUM_RTC KHR_texture_transform EXT_texture_webp",
              "EXT_texture_avif KHR_texture_basisu MSFT_texture_dds"},
     .unused = {"KHR_lights_punctual KHR_xmp_json_ld KHR_xmp FB_ngon_encoding CESIUM_primitive_outline",
                "GODOT_single_root OMI_physics_body OMI_physics_shape KHR_physics_rigid_bodies KHR_implicit_shapes",
                "KHR_animation_pointer"},
     .leftOut = {{"MSFT_lod", "levels of detail (MSFT_lod; the nodes of the scene are read, coarser ones too)"}}}};

Model readModel(const std::filesystem::path& file, const std::filesystem::path& name, bool allowOutside) {
  Model model;
  model.file = name;
  const std::string text = readContainer(file, model);
  try {
    const Json json = Json::parse(text);
    ModelReader(model, json, allowOutside).read();
  } catch (const Json::exception& e) {
    model.fail("is not valid glTF: {}", reasonOf(e));
  }
  return model;
}

}  // namespace scanmill::gltf
