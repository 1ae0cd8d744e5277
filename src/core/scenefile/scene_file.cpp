// Reads scene files (scenes/*.yaml), whose keys docs/keys.md lists.
//
// A part of an asset gets its class from the first of these that matches and has a class: the object's rules in their
// order, the object's class, the scene's rules in their order. Its material is found in the same way. An object's class
// therefore overrides the classes of all the scene's rules; an object overrides their materials only if it has a
// material too.

#include "scenefile/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "assets/asset.h"
#include "assets/asset_kinds.h"
#include "assets/surveys/surveys.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "base/random.h"
#include "config/distribution.h"
#include "config/file_kind.h"
#include "config/text.h"
#include "formats/cloud_file.h"
#include "scene/primitives.h"
#include "scenefile/concepts.h"
#include "scenefile/file_meshes.h"
#include "scenefile/labelling.h"
#include "scenefile/object_placer.h"
#include "scenefile/placement.h"
#include "scenefile/rules.h"
#include "town/town.h"

namespace scanmill {
namespace {

constexpr Range kLength{1e-6, 1e6};  // m, limits of the sizes of primitives

class SceneReader {
 public:
  SceneReader(SceneBuilder& builder, const SceneOptions& options, std::vector<Rule> rules,
              std::filesystem::path assetFolder)
      : builder_(builder),
        options_(options),
        rules_(std::move(rules)),
        assetFolder_(std::move(assetFolder)),
        files_(builder),
        placer_(builder, options.seed) {
    checkNames(rules_);
  }

  void readObject(const Value& value) {
    Fields f(value, "object");
    const std::string kind = kindOf(f);
    if (kind == "file") return readFileObject(f);
    if (kind == "primitive") return readPrimitive(f);
    if (hasTown_) throw InputError(value.where, "a scene can have only one town");
    hasTown_ = true;
    const Affine place = townPlace(f);
    Fields fields(f.require("town"), "town");
    addTown(builder_, fields, options_.seed, place);
  }

  // Returns which of the three kinds the object is. Throws InputError if it is none of them, or several.
  static std::string kindOf(const Fields& f) {
    const std::vector<std::string> kinds{"file", "primitive", "town"};
    std::vector<std::string> found;
    std::copy_if(kinds.begin(), kinds.end(), std::back_inserter(found), [&](const auto& kind) { return f.has(kind); });
    if (found.size() == 1) return found.front();
    if (f.has("street")) {
      throw InputError(f.where(), "the key street is no longer known: write `town: {district: street}`");
    }
    std::string hint;
    for (const Value::Entry& entry : f.value().entries) {
      const std::string meant = found.empty() ? nearest(entry.key, kinds) : "";
      if (!meant.empty()) hint = fmt::format("; by '{}', did you mean '{}'?", entry.key, meant);
    }
    throw InputError(f.where(),
                     "an object must have exactly one of the keys file, primitive and town (`town: {}` for a town with "
                     "defaults)" +
                         hint);
  }

  // Returns true if something in the scene depends on the seed.
  bool procedural() const { return hasTown_ || random_; }

  // Returns the pose of a town. Reads all keys of the object except `town`, which the caller reads.
  static Affine townPlace(Fields& f) {
    f.require("town");
    f.text("name", "town");
    f.refuse({"scale", "copies"}, "is not for towns: give the town's length");
    const Placement placement = readPlacement(f);
    f.finish();
    return toAffine(placement.object.pose);
  }

 private:
  Copies copiesOf(Fields& f) {
    Copies copies = placer_.read(f);
    random_ = random_ || copies.arrangement.random();
    return copies;
  }

  // Returns the path of the object's file and its name as the scene writes it. For {one_of: [...]}, returns both
  // for every listed file and for every file in a listed folder.
  std::vector<std::pair<std::filesystem::path, std::string>> filesOf(Fields& f, const Value& value) const {
    if (value.kind == Value::Kind::Sequence) {
      throw InputError(value.where,
                       "file must be one file: write an object for each, or {one_of: [...]}, from which each copy is "
                       "one at random");
    }
    if (value.kind != Value::Kind::Map) {
      const std::string name = f.text("file");
      const std::filesystem::path path = assetPath(name, value);
      if (isFolder(path)) {
        throw InputError(
            value.where,
            fmt::format(
                "'{}' is a folder: name a file in it, or write {{one_of: {}}}, from which each copy is one at random",
                path.string(), name));
      }
      return {{path, name}};
    }
    Fields choice(value, "file");
    choice.also({"one_of"}).finish();
    std::vector<std::pair<std::filesystem::path, std::string>> files;
    for (const std::string& name : choice.texts("one_of")) {
      const std::filesystem::path path = assetPath(name, value);
      if (!isFolder(path)) {
        files.emplace_back(path, name);
        continue;
      }
      const std::vector<std::filesystem::path> inside = assetsIn(path);
      if (inside.empty())
        throw InputError(value.where, fmt::format("'{}' is a folder without 3D files", path.string()));
      for (const std::filesystem::path& file : inside) {
        files.emplace_back(file, (std::filesystem::path(name) / file.lexically_relative(path)).string());
      }
    }
    if (files.empty()) throw InputError(value.where, "one_of names no file");
    return files;
  }

  void readFileObject(Fields& f) {
    const Value& fileValue = f.require("file");
    const auto files = filesOf(f, fileValue);
    AssetOptions asset;
    asset.textures = options_.textures;
    asset.metresPerUnit = f.number("unit", {1e-9, 1e9}, 1.0);
    asset.unitStated = f.has("unit");
    if (f.has("up")) asset.up = f.choice("up", {"x", "y", "z"}, "")[0];
    const std::string alpha = f.choice("alpha", {"auto", "ignore", "test"}, "auto");
    if (alpha != "auto") asset.alpha = alpha == "test" ? AlphaUse::Test : AlphaUse::Ignore;
    asset.allowOutside = f.boolean("allow_outside", false);
    asset.leaveOutMissing = f.choice("missing", {"refuse", "leave_out"}, "refuse") == "leave_out";
    for (const std::string& name : f.texts("textures")) {
      asset.textureFolders.push_back(assetPath(name, f.require("textures")));
      if (!isFolder(asset.textureFolders.back())) {
        throw InputError(f.require("textures").where,
                         fmt::format("textures: '{}' is no folder", asset.textureFolders.back().string()));
      }
    }
    const std::vector<Rule> rules = rulesOf(f);
    const std::string name = f.text("name", files.front().first.stem().string());
    Copies copies = copiesOf(f);
    const std::vector<std::string>& materials = copies.arrangement.materials();
    std::vector<LabelledFile> all;  // each copy gets one at random
    for (const auto& [file, called] : files) {
      LabelledFile variant{file, asset, {}};
      const bool cloud = isCloud(file);
      variant.labelling.file = called;
      variant.labelling.things = readThingBounds(f, cloud ? ThingBounds::By::Node : ThingBounds::By::Object);
      variant.labelling.things.byClass = cloud;
      variant.labelling.rules = rules;
      readSurveyOptions(f, file, variant.asset);
      for (const std::string& material : materials) {
        Rule own;
        own.where = f.require("vary").where;
        own.materialName = material;
        builder_.library().require(material, own.where);
        all.push_back(variant);
        all.back().labelling.rules.insert(all.back().labelling.rules.begin(), std::move(own));
      }
      if (materials.empty()) all.push_back(std::move(variant));
    }
    random_ = random_ || all.size() > 1;
    const std::optional<Clip> clip = clipOf(f);
    f.finish();

    if (clip && all.size() > 1) {
      throw InputError(f.require("animation").where, "animation is for objects of one file, which has the clip");
    }
    if (clip && !clip->second) {
      const ThingBounds& things = all.front().labelling.things;
      if (things.by == ThingBounds::By::Part) {
        throw InputError(
            things.where,
            "the connected parts of a playing clip can change at any time: give `instances` node, object or a pattern");
      }
      const std::shared_ptr<const Animation> animation = files_.playing(all.front(), clip->first, fileValue.where);
      if (animation->meshes.size() > 1) copies.animation = animation;
      return placer_.place(std::vector<PlacedMesh>{{animation->meshes.front(), {}, {}}}, name, copies, f.where());
    }
    if (clip) all.front().asset.clip = {clip->first, *clip->second};
    const auto meshes = [&](std::size_t k) -> const std::vector<PlacedMesh>& {
      return files_.read(all[k], fileValue.where);
    };
    placer_.place(Variants{all.size(), meshes}, name, copies, f.where());
    files_.compareSurveys(all[0], copies.placement.object.pose.translation, fileValue.where);
  }

  // A clip's name and the time (s) at which the clip is frozen; without a time the clip loops. Read from {clip: NAME,
  // time_s: t}.
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

  // Returns all rules for an object in order of precedence: first its own rules, then one rule with its class and
  // material, then the scene's rules.
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

  // Throws InputError for an unknown class or material of a rule, so that a typing error is found even if the rule
  // matches nothing.
  void checkNames(const std::vector<Rule>& rules) const {
    for (const Rule& rule : rules) {
      if (!rule.className.empty()) requireClass(builder_.ontology(), rule.className, rule.where);
      if (!rule.materialName.empty()) builder_.library().require(rule.materialName, rule.where);
    }
  }

  std::filesystem::path assetPath(const std::string& name, const Value& value) const {
    if (name.empty()) throw InputError(value.where, "file is empty");
    if (assetFolder_.empty() || std::filesystem::path(name).is_absolute()) return resolvePath(value, name);
    return assetFolder_ / name;
  }

  // Reads the keys of a primitive and appends its shape to a mesh. Returns a key that is the same for equal shapes.
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
    const SemanticClass& semantic = requireClass(builder_.ontology(), f.text("class"), className.where);
    surface.semantic = semantic.id;
    surface.object = semantic.thing ? 1 : 0;
    surface.material = builder_.material(f.text("material"), materialName.where);
    surface.labelledBy = className.where;
    const std::string name = f.text("name", kind);
    const Copies copies = copiesOf(f);
    if (!copies.arrangement.materials().empty()) {
      throw InputError(f.require("vary").where, "the key `material` of `vary` is only for objects that are files");
    }
    f.finish();

    const std::string key = fmt::format("primitive {} {} {}", shape, surface.semantic, surface.material);
    mesh.surfaces.push_back(std::move(surface));
    auto shared = meshes_.find(key);
    if (shared == meshes_.end()) shared = meshes_.emplace(key, builder_.addMesh(std::move(mesh))).first;
    placer_.place(std::vector<PlacedMesh>{{shared->second, {}, {}}}, name, copies, f.where());
  }

  SceneBuilder& builder_;
  const SceneOptions& options_;
  std::vector<Rule> rules_;
  std::filesystem::path assetFolder_;
  std::map<std::string, std::uint32_t> meshes_;
  FileMeshes files_;
  ObjectPlacer placer_;
  bool hasTown_ = false;
  bool random_ = false;
};

// Returns the scene's objects with a random value in place of each distribution, and appends these values to `draws`.
Value objectsOf(const Value& root, std::uint64_t seed, std::vector<DrawnValue>& draws) {
  const Value* objects = root.find("objects");
  if (objects == nullptr) return {};
  if (const Value* perFrame = findDrawnPerFrame(*objects)) {
    throw InputError(perFrame->where,
                     "`per: frame`: a scene's objects are the same in all frames: leave `per` out, for a random value "
                     "for each seed");
  }
  if (const Value* stratified = findStratified(*objects)) {
    throw InputError(
        stratified->where,
        "`stratify`: a scene does not know the splits of a dataset: leave it out; it is for the mounts and "
        "effects of a pipeline");
  }
  return withDraws(*objects, "objects", {.seed = seed}, draws);
}

// Reads the file of a scene and refuses keys that scenes do not have.
Value readSceneYaml(const std::filesystem::path& path) {
  Value root = readYaml(path);
  expectKind(root, FileKind::Scene);
  Fields(root, "scene").also({"name", "ontology", "materials", "assets", "rules", "objects"}).finish();
  return root;
}

}  // namespace

std::optional<SceneLanes> readSceneLanes(const std::filesystem::path& path, std::uint64_t seed) {
  const InputBudget budget;
  const Value root = readSceneYaml(path);
  std::vector<DrawnValue> draws;
  const Value objects = objectsOf(root, seed, draws);
  for (const Value& object : objects.items) {
    Fields f(object, "object");
    const std::string kind = SceneReader::kindOf(f);
    if (kind == "town") {
      const Affine place = SceneReader::townPlace(f);
      Fields fields(f.require("town"), "town");
      SceneLanes lanes = townLanes(fields, seed);
      for (std::vector<Vec3d>* way : {&lanes.lane, &lanes.turns}) {
        for (Vec3d& p : *way) p = place * p;
      }
      return lanes;
    }
  }
  return std::nullopt;
}

Ontology readSceneOntology(const std::filesystem::path& path) {
  const Value root = readSceneYaml(path);
  return readOntology(Fields(root, "scene").resource("ontology", "labels"));
}

Scene readScene(const std::filesystem::path& path, const SceneOptions& options) {
  const InputBudget budget;
  const Value root = readSceneYaml(path);
  Fields f(root, "scene");
  const std::string name = f.text("name", path.stem().string());
  f.text("ontology");
  const std::filesystem::path ontology = options.ontology.empty() ? f.resource("ontology", "labels") : options.ontology;
  const std::filesystem::path materials = f.resource("materials", "labels");
  const std::filesystem::path assets = f.optionalPath("assets").value_or(std::filesystem::path());
  std::vector<Rule> rules;
  if (const Value* value = f.find("rules")) rules = readRules(*value);
  const Value& listed = f.require("objects");
  if (listed.kind != Value::Kind::Sequence || (listed.items.empty() && !options.add)) {
    throw InputError(listed.where, "objects must be a list of at least one object");
  }
  std::vector<DrawnValue> draws;
  const Value objects = objectsOf(root, options.seed, draws);

  SceneBuilder builder(name, options.seed, readOntology(ontology), readMaterials(materials, options.wavelengthNm));
  SceneReader reader(builder, options, std::move(rules), assets);
  for (const Value& object : objects.items) reader.readObject(object);
  if (options.add) options.add(builder);
  Scene scene = builder.finish();
  scene.file = path;
  scene.procedural = reader.procedural() || !draws.empty();
  scene.draws = std::move(draws);
  return scene;
}

}  // namespace scanmill
