// A scene file, scenes/*.yaml:
//
//   name: town                           # default: the file's name
//   ontology: ../labels/scanmill.yaml    # relative to this file, as all paths; or one of the program's own: scanmill
//   materials: ../labels/materials.yaml
//   assets: ${SCANMILL_ASSETS}/town      # where relative `file`s start; default: this file's folder
//   rules: [{match: {node: "Road*"}, class: road, material: asphalt}, ...]
//   objects: [...]
//
// An object is one of
//
//   file: car.glb                        # an asset
//   up: y                                # the up axis of the file's coordinates, x, y or z, whatever it declares.
//                                        # Without this key: as COLLADA and FBX declare, y for glTF and AC3D, z for
//                                        # OBJ, PLY, STL and all others
//   unit: 0.01                           # metres per unit of the file; default 1; COLLADA and FBX declare theirs, and
//                                        # this is a factor on top
//   alpha: auto                          # whether beams pass where a base colour's alpha is below 0.5: test (yes),
//                                        # ignore (no: all is solid), auto (default: as the file's materials declare;
//                                        # where they do not, what looks like cut-outs: see AlphaUse in
//                                        scene/assets/asset.h)
//   instances: node                      # node: each node with a thing class is a thing of its own;
//                                        # object (default): the placed asset is one thing
//   animation: {clip: walk}              # of glTF: it plays over and over; with time_s it stands as it is then
//   rules: [...]                         # see scene/rules.h; what match: {file: ...} sees is `file` as written here
//   class: car, material: car_paint      # one more rule, which fits everything
//
//   The class of a part comes from the first that fits and names one, of: the object's rules in their order, the
//   object's class, the scene's rules in their order. So does the material. Hence an object's class hides the classes
//   of all the scene's rules, but not their materials, unless the object has a material too.
//
//   primitive: box                       # class and material are required. Centred at the origin, in metres:
//   size: [x, y, z]                      #   box; plane: [x, y] at z = 0, facing up, cut into cells x cells
//   radius, height, segments: ...        #   sphere (radius), cylinder and cone (along z), capsule (height is that of
//                                        #   the cylinder between the half spheres)
//
//   street: {...}                        # see scene/street.h
//   town: {...}                          # see scene/town.h
//
// and has a name, a position and copies (see scene/placement.h), and, but for streets and towns, may move:
//
//   moving: {velocity: [8, 0, 0]}        # see scene/movement.h; position and rotation are then relative to the
//   movement

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "config/file_kind.h"
#include "scene/assets/asset.h"
#include "scene/assets/gltf.h"
#include "scene/builder.h"
#include "scene/labelling.h"
#include "scene/placement.h"
#include "scene/primitives.h"
#include "scene/rules.h"
#include "scene/street.h"
#include "scene/town.h"

namespace scanmill {
namespace {

constexpr Range kLength{1e-6, 1e6};  // m

// A clip that plays is a mesh for every so much of it.
constexpr double kMoment = 0.05;  // s
constexpr double kMostMoments = 48;

class SceneReader {
 public:
  SceneReader(SceneBuilder& builder, const SceneOptions& options, std::vector<Rule> rules,
              std::filesystem::path assetFolder)
      : builder_(builder), options_(options), rules_(std::move(rules)), assetFolder_(std::move(assetFolder)) {
    checkNames(rules_);
  }

  void readObject(const Value& value) {
    Fields f(value, "object");
    const std::string kind = kindOf(f, value.where);
    if (kind == "file") return readFileObject(f);
    if (kind == "primitive") return readPrimitive(f);
    const bool street = kind == "street";
    if (towns_ > 0 || (!street && procedural_ > 0)) {
      throw InputError(value.where, "a town fills the ground about it: one a scene, and no street beside it");
    }
    towns_ += street ? 0 : 1;
    const Affine place = proceduralPlace(f, street ? "street" : "town");
    Fields fields(f.require(street ? "street" : "town"), street ? "street" : "town");
    const std::uint64_t seed = seedOfNext(options_.seed, procedural_++);
    if (street) {
      addStreet(builder_, fields, seed, place);
    } else {
      addTown(builder_, fields, seed, options_.supply, place);
    }
  }

  // Which of the four it is. Throws InputError where it is none, or several.
  static std::string kindOf(Fields& f, const Location& where) {
    std::string found;
    int count = 0;
    for (const char* kind : {"file", "primitive", "street", "town"}) {
      if (!f.has(kind)) continue;
      found = kind;
      ++count;
    }
    if (count != 1) {
      f.also({"file",     "primitive", "street", "town",   "name",   "position", "yaw_deg",   "pitch_deg", "roll_deg",
              "rotation", "scale",     "copies", "up",     "unit",   "alpha",    "instances", "rules",     "class",
              "material", "size",      "cells",  "radius", "height", "segments", "moving",    "animation"})
          .finish();
      throw InputError(where,
                       "an object is exactly one of file, primitive, street and town (`town: {}` where all of its "
                       "keys keep their defaults)");
    }
    return found;
  }

  bool procedural() const { return procedural_ > 0; }

  // Odd, so that the streets of one scene and those of the scenes with the next seeds all differ.
  static std::uint64_t seedOfNext(std::uint64_t seed, std::uint64_t before) {
    return seed + 0x9E3779B97F4A7C15 * before;
  }

  // Where a street or a town stands; all of the object's own keys but the one that says what it is.
  static Affine proceduralPlace(Fields& f, const std::string& what) {
    f.require(what);
    f.text("name", what);
    const Placement placement = readPlacement(f);
    f.finish();
    if (placement.scaled || placement.copied) {
      throw InputError(f.where(), fmt::format("a {0} has neither scale nor copies: give its lengths, or write another "
                                              "{0}",
                                              what));
    }
    return toAffine(placement.object.pose);
  }

 private:
  static std::shared_ptr<const Movement> movementOf(Fields& f) {
    const Value* moving = f.find("moving");
    return moving == nullptr ? nullptr : readMovement(*moving);
  }

  void placeAll(std::uint32_t mesh, const std::string& name, const Placement& placement,
                const std::shared_ptr<const Movement>& movement, const Location& where,
                const std::shared_ptr<const Animation>& animation = nullptr) {
    placed_ += placement.count();
    if (placed_ > Placement::kMostCopies) {
      throw InputError(where, fmt::format("with these {} copies the scene has {} placed objects; at most {} are made",
                                          placement.count(), placed_, Placement::kMostCopies));
    }
    std::uint64_t number = 0;
    placement.forEach([&](const Affine& worldFromMesh) {
      ++number;
      builder_.place(mesh, worldFromMesh, placement.count() == 1 ? name : fmt::format("{}#{}", name, number), where,
                     movement, animation);
    });
  }

  void readFileObject(Fields& f) {
    const Value& fileValue = f.require("file");
    Labelling labelling;
    labelling.file = f.text("file");
    const std::filesystem::path file = assetPath(labelling.file, fileValue);
    AssetOptions asset;
    asset.textures = options_.textures;
    asset.metresPerUnit = f.number("unit", {1e-9, 1e9}, 1.0);
    if (f.has("up")) asset.up = f.choice("up", {"x", "y", "z"}, "")[0];
    const std::string alpha = f.choice("alpha", {"auto", "ignore", "test"}, "auto");
    if (alpha != "auto") asset.alpha = alpha == "test" ? AlphaUse::Test : AlphaUse::Ignore;
    labelling.perNode = f.choice("instances", {"object", "node"}, "object") == "node";
    labelling.rules = rulesOf(f);
    const std::string name = f.text("name", file.stem().string());
    const Placement placement = readPlacement(f);
    const std::shared_ptr<const Movement> movement = movementOf(f);
    const std::optional<Clip> clip = clipOf(f);
    f.finish();

    if (clip && !clip->second) {
      const std::shared_ptr<const Animation> animation =
          momentsOf(file, asset, labelling, clip->first, fileValue.where);
      const bool plays = animation->meshes.size() > 1;
      return placeAll(animation->meshes.front(), name, placement, movement, f.where(), plays ? animation : nullptr);
    }
    if (clip) asset.clip = {clip->first, *clip->second};
    const std::string key = meshKey(file, asset, labelling);
    auto mesh = meshes_.find(key);
    if (mesh == meshes_.end()) {
      const std::uint32_t made =
          addAsset(builder_, load(file, asset, labelling, fileValue.where), labelling, fileValue.where);
      mesh = meshes_.emplace(key, made).first;
    }
    placeAll(mesh->second, name, placement, movement, f.where());
  }

  // The meshes of a clip that plays. All have the materials of the first, so that pictures are kept once.
  std::shared_ptr<const Animation> momentsOf(const std::filesystem::path& file, AssetOptions options,
                                             Labelling labelling, const std::string& clip, const Location& where) {
    std::shared_ptr<const Animation>& known = animations_[clip + '\n' + meshKey(file, options, labelling)];
    if (known != nullptr) return known;
    options.clip = {clip, 0};  // which is as at its first key frame
    Asset moment = load(file, options, labelling, where);
    const auto [first, last] = clipSpan(file, clip);
    const double moments = std::clamp(std::ceil((last - first) / kMoment), 1.0, kMostMoments);
    std::vector<Material> materials;
    for (const AssetPart& part : moment.parts) materials.push_back(part.fileMaterial);
    options.textures = false;
    const auto animation = std::make_shared<Animation>();
    for (int k = 0; k < moments; ++k) {
      options.clip->time = first + (last - first) * k / moments;
      if (k > 0) moment = load(file, options, labelling, where);
      if (moment.parts.size() == materials.size()) {
        for (std::size_t i = 0; i < materials.size(); ++i) moment.parts[i].fileMaterial = materials[i];
      }
      animation->meshes.push_back(addAsset(builder_, std::move(moment), labelling, where));
      labelling.counted = true;
    }
    animation->period = std::max(last - first, 1e-3);
    animation->until = std::numeric_limits<double>::infinity();
    return known = animation;
  }

  // Of {clip: NAME, time_s: t}: the clip, and when it is held; without a time it plays over and over.
  using Clip = std::pair<std::string, std::optional<double>>;
  static std::optional<Clip> clipOf(Fields& f) {
    const Value* const value = f.find("animation");
    if (value == nullptr) return std::nullopt;
    Fields fields(*value, "animation");
    fields.also({"clip", "time_s"});
    Clip clip{fields.text("clip"), std::nullopt};
    if (fields.has("time_s")) clip.second = fields.number("time_s", {0, 1e6});
    fields.finish();
    return clip;
  }

  // The object's own rules, its shorthand, the scene's rules.
  std::vector<Rule> rulesOf(Fields& f) {
    std::vector<Rule> rules;
    if (const Value* own = f.find("rules")) rules = readRules(*own);
    Rule shorthand;
    if (const Value* value = f.find("class")) {
      shorthand.where = value->where;
      shorthand.className = f.text("class");
    }
    if (const Value* value = f.find("material")) {
      if (shorthand.className.empty()) shorthand.where = value->where;
      shorthand.materialName = f.text("material");
    }
    if (!shorthand.className.empty() || !shorthand.materialName.empty()) rules.push_back(std::move(shorthand));
    checkNames(rules);
    rules.insert(rules.end(), rules_.begin(), rules_.end());
    return rules;
  }

  // A typing error is found even where the rule matches nothing.
  void checkNames(const std::vector<Rule>& rules) const {
    for (const Rule& rule : rules) {
      if (!rule.className.empty()) builder_.ontology().require(rule.className, rule.where);
      if (!rule.materialName.empty()) builder_.library().require(rule.materialName, rule.where);
    }
  }

  std::filesystem::path assetPath(const std::string& name, const Value& value) const {
    if (name.empty()) throw InputError(value.where, "file is empty");
    if (assetFolder_.empty() || std::filesystem::path(name).is_absolute()) return resolvePath(value, name);
    return assetFolder_ / name;
  }

  // Objects with equal keys share a mesh.
  static std::string meshKey(const std::filesystem::path& file, const AssetOptions& asset, const Labelling& labelling) {
    std::error_code ignored;
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(file, ignored);
    std::string key =
        fmt::format("{}\n{}\n{}\n{}\n{}\n{}", (ignored ? file : canonical).string(), labelling.file,
                    asset.metresPerUnit, asset.up.value_or('-'), static_cast<int>(asset.alpha), labelling.perNode);
    if (asset.clip) key += fmt::format("\n{}\n{}", asset.clip->clip, asset.clip->time);
    for (const Rule& r : labelling.rules) {
      for (const std::string* text : {&r.node, &r.material, &r.texture, &r.file, &r.className, &r.materialName}) {
        key += fmt::format("\n{}:{}", text->size(), *text);
      }
    }
    return key;
  }

  // Decoding base colours can cost more than all the rest, and materials of the library seldom need them: where rules
  // name materials, the asset is read without textures first, and again only if some part shows its own.
  Asset load(const std::filesystem::path& file, const AssetOptions& options, const Labelling& labelling,
             const Location& where) const {
    try {
      const bool mayDoWithout = std::any_of(labelling.rules.begin(), labelling.rules.end(),
                                            [](const Rule& rule) { return !rule.materialName.empty(); });
      if (!options.textures || !mayDoWithout) return readAsset(file, options);
      AssetOptions plain = options;
      plain.textures = false;
      Asset asset = readAsset(file, plain);
      if (showsTextures(builder_, asset, labelling)) asset = readAsset(file, options);
      return asset;
    } catch (const InputError& e) {
      throw InputError(where, e.what());
    }
  }

  // The shape of a primitive: reads its keys, and appends it to a mesh with the key that equal shapes share.
  static std::string appendPrimitive(Fields& f, const std::string& kind, Mesh& mesh) {
    if (kind == "box") {
      const Vec3d size = readSize(f.require("size"), 3);
      appendBox(mesh, 0, {}, size);
      return fmt::format("box {} {} {}", size.x, size.y, size.z);
    }
    if (kind == "plane") {
      const Vec3d size = readSize(f.require("size"), 2);
      const auto cells = static_cast<int>(f.integer("cells", 1, 2048, 1));
      appendPlane(mesh, 0, {}, size.x, size.y, cells);
      return fmt::format("plane {} {} {}", size.x, size.y, cells);
    }
    const double radius = f.number("radius", kLength);
    const double height = kind == "sphere" ? 0 : f.number("height", kLength);
    const auto segments = static_cast<int>(f.integer("segments", 3, 4096, 32));
    if (kind == "sphere") appendSphere(mesh, 0, {}, radius, segments);
    if (kind == "cylinder") appendCylinder(mesh, 0, {}, radius, radius, height, segments);
    if (kind == "cone") appendCylinder(mesh, 0, {}, radius, 0, height, segments);
    if (kind == "capsule") appendCapsule(mesh, 0, {}, radius, height, segments);
    return fmt::format("{} {} {} {}", kind, radius, height, segments);
  }

  static Vec3d readSize(const Value& value, std::size_t count) {
    std::vector<double> size = readNumbers(value, "size", kLength);
    if (size.size() != count) {
      throw InputError(value.where, fmt::format("size must be {}, found {} numbers",
                                                count == 3 ? "[x, y, z]" : "[x, y]", size.size()));
    }
    size.resize(3);
    return {size[0], size[1], size[2]};
  }

  void readPrimitive(Fields& f) {
    const std::string kind = f.choice("primitive", {"box", "sphere", "cylinder", "cone", "plane", "capsule"}, "");
    Mesh mesh;
    mesh.name = kind;
    const std::string shape = appendPrimitive(f, kind, mesh);
    const Value& className = f.require("class");
    const Value& materialName = f.require("material");
    Surface surface;
    const SemanticClass& semantic = builder_.ontology().require(f.text("class"), className.where);
    surface.semantic = semantic.id;
    surface.object = semantic.thing ? 1 : 0;
    surface.material = builder_.material(f.text("material"), materialName.where);
    const std::string name = f.text("name", kind);
    const Placement placement = readPlacement(f);
    const std::shared_ptr<const Movement> movement = movementOf(f);
    f.finish();

    const std::string key = fmt::format("primitive {} {} {}", shape, surface.semantic, surface.material);
    mesh.surfaces.push_back(std::move(surface));
    auto shared = meshes_.find(key);
    if (shared == meshes_.end()) shared = meshes_.emplace(key, builder_.addMesh(std::move(mesh))).first;
    placeAll(shared->second, name, placement, movement, f.where());
  }

  SceneBuilder& builder_;
  const SceneOptions& options_;
  std::vector<Rule> rules_;
  std::filesystem::path assetFolder_;
  std::map<std::string, std::uint32_t> meshes_;
  std::map<std::string, std::shared_ptr<const Animation>> animations_;
  std::uint64_t placed_ = 0;
  std::uint64_t procedural_ = 0;
  std::uint64_t towns_ = 0;
};

}  // namespace

std::optional<SceneLanes> readSceneLanes(const std::filesystem::path& path, std::uint64_t seed) {
  const Value root = readYaml(path);
  expectKind(root, FileKind::Scene);
  const Value* objects = root.find("objects");
  std::uint64_t before = 0;
  for (const Value& object : objects == nullptr ? std::vector<Value>{} : objects->items) {
    Fields f(object, "object");
    const std::string kind = SceneReader::kindOf(f, object.where);
    if (kind == "town") {
      const Affine place = SceneReader::proceduralPlace(f, "town");
      Fields fields(f.require("town"), "town");
      SceneLanes lanes = townLanes(fields, SceneReader::seedOfNext(seed, before));
      for (std::vector<Vec3d>* way : {&lanes.lane, &lanes.turns}) {
        for (Vec3d& p : *way) p = place * p;
      }
      return lanes;
    }
    before += kind == "street" ? 1 : 0;
  }
  return std::nullopt;
}

Ontology readSceneOntology(const std::filesystem::path& path) {
  const Value root = readYaml(path);
  expectKind(root, FileKind::Scene);
  Fields f(root, "scene");
  f.also({"name", "ontology", "materials", "assets", "rules", "objects"}).finish();
  return readOntology(f.resource("ontology", "labels"));
}

Scene readScene(const std::filesystem::path& path, const SceneOptions& options) {
  const Value root = readYaml(path);
  expectKind(root, FileKind::Scene);
  Fields f(root, "scene");
  f.also({"name", "ontology", "materials", "assets", "rules", "objects"}).finish();
  const std::string name = f.text("name", path.stem().string());
  f.text("ontology");
  const std::filesystem::path ontology = options.ontology.empty() ? f.resource("ontology", "labels") : options.ontology;
  const std::filesystem::path materials = f.resource("materials", "labels");
  const std::filesystem::path assets = f.optionalPath("assets").value_or(std::filesystem::path());
  std::vector<Rule> rules;
  if (const Value* value = f.find("rules")) rules = readRules(*value);
  const Value& objects = f.require("objects");
  if (objects.kind != Value::Kind::Sequence || objects.items.empty()) {
    throw InputError(objects.where, "objects must be a list of at least one object");
  }

  SceneBuilder builder(name, options.seed, readOntology(ontology), readMaterials(materials, options.wavelengthNm));
  SceneReader reader(builder, options, std::move(rules), assets);
  for (const Value& object : objects.items) reader.readObject(object);
  Scene scene = builder.finish();
  scene.file = path;
  scene.procedural = reader.procedural();
  return scene;
}

}  // namespace scanmill
