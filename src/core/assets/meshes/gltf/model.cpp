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

constexpr int kMaxDepth = 512;

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
      if (!isAppearance(name.get<std::string>())) m_.leftOut.addKeyword(gltfFormat(), name.get<std::string>());
    }
    if (const auto extensions = json_.find("extensions"); extensions != json_.end() && extensions->is_object()) {
      if (const auto rtc = extensions->find("CESIUM_RTC"); rtc != extensions->end()) {
        const auto c = rtc->at("center").get<std::array<double, 3>>();
        m_.center = Vec3d{c[0], c[1], c[2]};
      }
    }
    readStorage(m_, json_, allowOutside_);
    each("images", m_.images, [&](const Json& j, const std::string& what) { return image(j, what); });
    each("materials", m_.materials, [&](const Json& j, const std::string& what) { return material(j, what); });
    each("meshes", m_.meshes, [&](const Json& j, const std::string& what) { return mesh(j, what); });
    each("skins", m_.skins, [&](const Json& j, const std::string& what) { return skin(j, what); });
    each("nodes", m_.nodes, [&](const Json& j, const std::string& what) { return node(j, what); });
    each("animations", m_.animations, [&](const Json& j, const std::string& what) { return animation(j, what); });
    scene();
  }

 private:
  Attributes attributes(const Json& object, const std::string& what) const {
    Attributes found;
    for (const auto& [name, value] : object.items()) found[name] = index(value, m_.accessors.size(), what + "." + name);
    return found;
  }

  // Counts the colours and the values with names of their own, such as _BATCHID, of vertices or instances.
  void countUnread(const Attributes& attributes, const char* of) const {
    for (const auto& [name, accessor] : attributes) {
      const bool color = name.starts_with("COLOR_");
      if (!color && !name.starts_with('_')) continue;
      m_.leftOut.add(fmt::format("{} of {} ({})", color ? "colours" : "values", of, name.substr(0, 40)),
                     m_.accessors[accessor].count);
    }
  }

  Image image(const Json& j, const std::string& what) const {
    Image i;
    i.name = j.value("name", std::string());
    i.view = maybe(j, "bufferView", m_.views.size(), what);
    if (j.contains("uri")) {
      i.uri = j["uri"].get<std::string>();
      if (!i.uri.starts_with("data:")) i.uri = decodeUri(i.uri);
    }
    return i;
  }

  // Returns the image of a texture, which may be in an extension; nullopt if the texture names no image.
  MaybeIndex imageOf(Index texture) const {
    const Json& j = list("textures")[texture];
    const std::string what = fmt::format("textures[{}]", texture);
    if (const MaybeIndex source = maybe(j, "source", m_.images.size(), what)) return source;
    for (const char* name : {"EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"}) {
      if (const Json* extension = extensionOf(j, name)) {
        if (const MaybeIndex source = maybe(*extension, "source", m_.images.size(), what)) return source;
      }
    }
    return std::nullopt;
  }

  // False if the sampler of a texture clamps or mirrors it.
  bool repeats(Index texture) const {
    constexpr int kRepeat = 10497;
    const MaybeIndex sampler =
        maybe(list("textures")[texture], "sampler", list("samplers").size(), fmt::format("textures[{}]", texture));
    if (!sampler) return true;
    const Json& s = list("samplers")[*sampler];
    return s.value("wrapS", kRepeat) == kRepeat && s.value("wrapT", kRepeat) == kRepeat;
  }

  std::optional<TextureUse> textureUse(const Json& object, const char* key, const std::string& what) const {
    const auto found = object.find(key);
    if (found == object.end()) return std::nullopt;
    const std::string valueName = what + "." + key;
    const MaybeIndex image = imageOf(index(found->at("index"), list("textures").size(), valueName));
    if (!image) return std::nullopt;
    TextureUse use;
    use.image = *image;
    use.repeats = repeats(index(found->at("index"), list("textures").size(), valueName));
    use.coordinates = static_cast<unsigned>(std::min<std::uint64_t>(length(*found, "texCoord", 0, valueName), 1000));
    if (const Json* transform = extensionOf(*found, "KHR_texture_transform")) {
      numbers(*transform, "offset", valueName, use.offset);
      numbers(*transform, "scale", valueName, use.scale);
      use.rotation = transform->value("rotation", 0.0);
      use.coordinates = static_cast<unsigned>(
          std::min<std::uint64_t>(length(*transform, "texCoord", use.coordinates, valueName), 1000));
    }
    return use;
  }

  Material material(const Json& j, const std::string& what) const {
    Material m;
    m.name = j.value("name", std::string());
    if (const Json* old = extensionOf(j, "KHR_materials_pbrSpecularGlossiness")) {
      numbers(*old, "diffuseFactor", what, m.color);
      m.texture = textureUse(*old, "diffuseTexture", what);
      m.metallic = 0;
      m.roughness = 1 - old->value("glossinessFactor", 1.0);
    } else if (const Json* pbr = objectIn(j, "pbrMetallicRoughness")) {
      numbers(*pbr, "baseColorFactor", what, m.color);
      m.texture = textureUse(*pbr, "baseColorTexture", what);
      m.metallic = pbr->value("metallicFactor", 1.0);
      m.roughness = pbr->value("roughnessFactor", 1.0);
    }
    const Json* const glass = extensionOf(j, "KHR_materials_transmission");
    if (glass != nullptr && glass->value("transmissionFactor", 0.0) > 0) {
      m.leftOut.add("transmissions of materials (they are solid)");
    }
    if (!m.texture && std::max({m.color[0], m.color[1], m.color[2]}) == 0 && j.contains("emissiveTexture")) {
      m.leftOut.add("emissive images of materials with a black base colour");
    }
    const std::string mode = j.value("alphaMode", std::string("OPAQUE"));
    m.alpha = mode == "MASK"    ? Material::Alpha::Mask
              : mode == "BLEND" ? Material::Alpha::Blend
                                : Material::Alpha::Opaque;
    m.cutoff = j.value("alphaCutoff", 0.5);
    return m;
  }

  Mesh mesh(const Json& j, const std::string& what) const {
    Mesh m;
    m.name = j.value("name", std::string());
    if (j.contains("weights")) m.weights = j["weights"].get<std::vector<double>>();
    const Json& primitives = j.at("primitives");
    if (!primitives.is_array()) fail(what + ".primitives is not a list");
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const std::string primitiveName = fmt::format("{}.primitives[{}]", what, i);
      const std::uint64_t mode = length(primitives[i], "mode", 4, primitiveName);
      if (mode > 6) fail(primitiveName + " has an unknown mode");
      if (mode < 4) {
        m_.leftOut.add(mode == 0 ? "primitives of points" : "primitives of lines");
        continue;
      }
      Primitive p = primitive(primitives[i], primitiveName);
      p.mode = static_cast<Primitive::Mode>(mode);
      countUnread(p.attributes, "vertices");
      if (p.attributes.contains("POSITION")) {
        m.primitives.push_back(std::move(p));
      } else {
        m_.leftOut.add("primitives without positions");
      }
    }
    return m;
  }

  Primitive primitive(const Json& j, const std::string& what) const {
    Primitive p;
    p.material = maybe(j, "material", m_.materials.size(), what);
    if (!j.contains("attributes") || !j["attributes"].is_object()) return p;
    p.attributes = attributes(j["attributes"], what);
    p.indices = maybe(j, "indices", m_.accessors.size(), what);
    const auto position = p.attributes.find("POSITION");
    if (position == p.attributes.end()) return p;
    const Accessor& positions = m_.accessors[position->second];
    if (positions.width != 3) fail(what + " has positions that do not have 3 numbers");
    if (const Json* draco = extensionOf(j, "KHR_draco_mesh_compression")) {
      p.draco = Primitive::Draco{};
      p.draco->view = index(draco->at("bufferView"), m_.views.size(), what + ".bufferView");
      for (const auto& [name, id] : draco->at("attributes").items()) {
        p.draco->attributes[name] = static_cast<std::uint32_t>(index(id, UINT32_MAX, what + "." + name));
      }
      if (!p.draco->attributes.contains("POSITION")) {
        fail(fmt::format("is not valid glTF: {} has no compressed positions", what));
      }
    } else if (p.indices) {
      const Accessor& indices = m_.accessors[*p.indices];
      if (indices.width != 1) fail(what + " has indices that are not single numbers");
      if (!indices.view && !indices.sparse && indices.count > 0) fail(what + " has indices without data");
    }
    for (const Json& target : listIn(j, "targets", what + ".targets")) p.targets.push_back(attributes(target, what));
    return p;
  }

  Skin skin(const Json& j, const std::string& what) const {
    Skin s;
    const std::size_t nodes = list("nodes").size();
    for (const Json& joint : j.at("joints")) s.joints.push_back(index(joint, nodes, what + ".joints"));
    s.inverseBindMatrices = maybe(j, "inverseBindMatrices", m_.accessors.size(), what);
    if (s.inverseBindMatrices) {
      const Accessor& a = m_.accessors[*s.inverseBindMatrices];
      if (a.width != 16 || a.count < s.joints.size()) {
        fail(fmt::format("is not valid glTF: {} has fewer matrices than joints", what));
      }
    }
    return s;
  }

  Node node(const Json& j, const std::string& what) const {
    Node n;
    n.name = j.value("name", std::string());
    const std::size_t nodes = list("nodes").size();
    for (const Json& child : listIn(j, "children", what + ".children")) {
      n.children.push_back(index(child, nodes, "a child of a node"));
    }
    n.mesh = maybe(j, "mesh", m_.meshes.size(), what);
    n.skin = maybe(j, "skin", m_.skins.size(), what);
    if (j.contains("weights")) n.weights = j["weights"].get<std::vector<double>>();
    std::array<double, 16> matrix{};
    if (numbers(j, "matrix", what, matrix)) n.matrix = matrix;
    numbers(j, "translation", what, n.translation);
    numbers(j, "rotation", what, n.rotation);
    numbers(j, "scale", what, n.scale);
    if (const Json* visibility = extensionOf(j, "KHR_node_visibility")) n.visible = visibility->value("visible", true);
    if (const Json* instancing = extensionOf(j, "EXT_mesh_gpu_instancing")) {
      const std::string extensionName = what + ".EXT_mesh_gpu_instancing";
      n.instances = attributes(instancing->at("attributes"), extensionName);
      countUnread(*n.instances, "instances");
      const auto first = n.instances->begin();
      for (const auto& [name, accessor] : *n.instances) {
        if (m_.accessors[accessor].count != m_.accessors[first->second].count) {
          fail(fmt::format("is not valid glTF: {} has {} values of {}, but {} of {}", extensionName,
                           m_.accessors[first->second].count, first->first, m_.accessors[accessor].count, name));
        }
      }
    }
    return n;
  }

  Animation animation(const Json& j, const std::string& what) const {
    Animation a;
    a.name = j.value("name", std::string());
    for (const Json& s : j.at("samplers")) {
      Animation::Sampler sampler;
      sampler.input = index(s.at("input"), m_.accessors.size(), what + ".input");
      sampler.output = index(s.at("output"), m_.accessors.size(), what + ".output");
      const std::string how = s.value("interpolation", std::string("LINEAR"));
      sampler.interpolation = how == "STEP"          ? Animation::Interpolation::Step
                              : how == "CUBICSPLINE" ? Animation::Interpolation::CubicSpline
                                                     : Animation::Interpolation::Linear;
      a.samplers.push_back(sampler);
    }
    for (const Json& c : j.at("channels")) {
      using Path = Animation::Path;
      static const std::map<std::string, Path> kPaths{{"translation", Path::Translation},
                                                      {"rotation", Path::Rotation},
                                                      {"scale", Path::Scale},
                                                      {"weights", Path::Weights}};
      Animation::Channel channel;
      channel.sampler = index(c.at("sampler"), a.samplers.size(), what + ": a channel's sampler");
      const Json& target = c.at("target");
      const std::string path = target.at("path").get<std::string>();
      a.pointers += path == "pointer" ? 1 : 0;
      const auto known = kPaths.find(path);
      if (known == kPaths.end() || !target.contains("node")) continue;  // skips channels with other targets
      channel.path = known->second;
      channel.node = index(target["node"], m_.nodes.size(), what + "'s target");
      a.channels.push_back(channel);
    }
    return a;
  }

  // Reads the scene; without one, all nodes that are nobody's children are its roots. Throws unless each of its nodes
  // is reached only once, without cycles or shared children.
  void scene() {
    const Json& scenes = list("scenes");
    if (scenes.empty()) {
      std::vector<bool> isChild(m_.nodes.size(), false);
      for (const Node& node : m_.nodes) {
        for (const Index child : node.children) isChild[child] = true;
      }
      for (Index i = 0; i < m_.nodes.size(); ++i) {
        if (!isChild[i]) m_.roots.push_back(i);
      }
    } else {
      const MaybeIndex chosen = maybe(json_, "scene", scenes.size(), "the file");
      for (const Json& root : listIn(scenes[chosen.value_or(0)], "nodes", "nodes of a scene")) {
        m_.roots.push_back(index(root, m_.nodes.size(), "a node of the scene"));
      }
    }
    std::vector<std::pair<Index, int>> open;
    for (const Index root : m_.roots) open.emplace_back(root, 1);
    std::vector<bool> seen(m_.nodes.size(), false);
    while (!open.empty()) {
      const auto [at, depth] = open.back();
      open.pop_back();
      if (seen[at]) fail(fmt::format("nodes[{}] has two parents, or is its own ancestor", at));
      if (depth > kMaxDepth) fail(fmt::format("has nodes that are nested more than {} levels deep", kMaxDepth));
      seen[at] = true;
      for (const Index child : m_.nodes[at].children) open.emplace_back(child, depth + 1);
    }
    for (Index i = 0; i < m_.nodes.size(); ++i) {
      if (!seen[i] && m_.nodes[i].mesh) m_.leftOut.add("nodes outside of the scene");
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

void Model::fail(const std::string& what) const {
  throw InputError({file.string()}, what);
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
