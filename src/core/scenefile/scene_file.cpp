// Reads scene files (scenes/*.yaml), whose keys docs/keys.md lists.

#include "scenefile/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "assets/worlds/world_asset.h"
#include "base/input_budget.h"
#include "base/random.h"
#include "config/distribution.h"
#include "config/resources.h"
#include "config/text.h"
#include "scene/primitives.h"
#include "scenefile/concepts.h"
#include "scenefile/file_objects.h"
#include "scenefile/object_placer.h"
#include "scenefile/rules.h"
#include "town/town.h"

namespace scanmill {
namespace {

// Returns the name of the key that the object has: `file`, `primitive` or `town`. Throws InputError if it has none or
// several of these keys.
std::string kindOf(const Fields& object) {
  const std::vector<std::string> keys{"file", "primitive", "town"};
  std::vector<std::string> objectKinds;
  std::ranges::copy_if(keys, std::back_inserter(objectKinds), [&](const auto& kind) { return object.has(kind); });
  if (objectKinds.size() == 1) return objectKinds.front();
  if (object.has("street")) {
    throw InputError(object.where(), "the key street is no longer known: write `town: {district: street}`");
  }
  std::string hint;
  for (const Value::Entry& entry : object.value().entries) {
    const std::string hintedKind = objectKinds.empty() ? nearest(entry.key, keys) : "";
    if (!hintedKind.empty()) hint = fmt::format("; by '{}', did you mean '{}'?", entry.key, hintedKind);
  }
  throw InputError(object.where(),
                   "an object must have exactly one of the keys file, primitive and town (`town: {}` for a town with "
                   "defaults)" +
                       hint);
}

// Returns the pose of a town (worldFromTown). Reads all keys of the object except `town`, which the caller reads.
Affine readTownPose(Fields& object) {
  object.require("town");
  object.text("name", "town");
  object.refuse({"scale", "copies"}, "is not for towns: give the town's length");
  const Placement placement = readPlacement(object);
  object.finish();
  return toAffine(placement.object.pose);
}

// Returns the object that is a town; null if there is none. Throws InputError for a second town.
const Value* findTown(const Value& objects) {
  const Value* town = nullptr;
  for (const Value& object : objects.items) {
    if (kindOf(Fields(object, "object")) != "town") continue;
    if (town != nullptr) throw InputError(object.where, "a scene can have only one town");
    town = &object;
  }
  return town;
}

constexpr Range kLength{1e-6, 1e6};  // m, limits of the sizes of primitives

// Reads [x, y, z] (m) or, if `count` is 2, [x, y], to which it adds z = 0.
Vec3d readSize(const Value& value, std::size_t count) {
  std::vector<double> size = readNumbers(value, "size", kLength);
  if (size.size() != count) {
    throw InputError(value.where, "size must be {}, found {} numbers", count == 3 ? "[x, y, z]" : "[x, y]",
                     size.size());
  }
  size.resize(3);
  return {size[0], size[1], size[2]};
}

// Reads the keys of a primitive and appends its shape to a mesh. Returns a key that is the same for equal shapes.
std::string appendPrimitive(Fields& object, const std::string& kind, Mesh& mesh) {
  constexpr std::uint16_t kSurface = 0;
  if (kind == "box") {
    const Vec3d size = readSize(object.require("size"), 3);
    appendBox(mesh, kSurface, {}, size);
    return fmt::format("box {} {} {}", size.x, size.y, size.z);
  }
  if (kind == "plane") {
    const Vec3d size = readSize(object.require("size"), 2);
    const auto cells = static_cast<int>(object.integer("cells", 1, 2048, 1));
    appendPlane(mesh, kSurface, {}, size.x, size.y, cells);
    return fmt::format("plane {} {} {}", size.x, size.y, cells);
  }
  const double radius = object.number("radius", kLength);
  const double height = kind == "sphere" ? 0 : object.number("height", kLength);
  const auto segments = static_cast<int>(object.integer("segments", 3, 4096, 32));
  if (kind == "sphere") appendSphere(mesh, kSurface, {}, radius, segments);
  if (kind == "cylinder") appendCylinder(mesh, kSurface, {}, radius, radius, height, segments);
  if (kind == "cone") appendCylinder(mesh, kSurface, {}, radius, 0, height, segments);
  if (kind == "capsule") appendCapsule(mesh, kSurface, {}, radius, height, segments);
  return fmt::format("{} {} {} {}", kind, radius, height, segments);
}

// Reads an object with the key `primitive` and places its copies. Equal shapes of one class and material share a mesh.
// `meshes`: the meshes of the primitives so far, by shape, class and material.
void addPrimitive(Fields& object, SceneBuilder& builder, ObjectPlacer& placer,
                  std::map<std::string, std::uint32_t>& meshes) {
  const std::string kind = object.choice("primitive", {"box", "sphere", "cylinder", "cone", "plane", "capsule"}, "");
  Mesh mesh;
  mesh.name = kind;
  const std::string shape = appendPrimitive(object, kind, mesh);
  const Value& className = object.require("class");
  const Value& materialName = object.require("material");
  const SemanticClass& semantic = requireClass(builder.ontology(), object.text("class"), className.where);
  Surface surface{.material = builder.material(object.text("material"), materialName.where),
                  .semantic = semantic.id,
                  .object = semantic.thing ? 1u : 0u,
                  .labelledBy = className.where};
  const std::string name = object.text("name", kind);
  const Copies copies = placer.read(object);
  if (!copies.arrangement.materials().empty()) {
    throw InputError(object.require("vary").where, "the key `material` of `vary` is only for objects that are files");
  }
  object.finish();

  const std::string key = fmt::format("{} {} {}", shape, surface.semantic, surface.material);
  mesh.surfaces.push_back(std::move(surface));
  auto meshIndex = meshes.find(key);
  if (meshIndex == meshes.end()) meshIndex = meshes.emplace(key, builder.addMesh(std::move(mesh))).first;
  placer.place(meshIndex->second, name, copies, object.where());
}

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
    throw InputError(stratified->where,
                     "`stratify`: a scene does not know the splits of a dataset: leave it out; it is for the mounts "
                     "and effects of a pipeline");
  }
  return withDraws(*objects, "objects", {.seed = seed}, draws);
}

// Reads the file of a scene. Throws InputError for keys that scenes do not have.
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
  const Value* const town = findTown(objects);
  if (town == nullptr) return std::nullopt;
  Fields object(*town, "object");
  const Affine worldFromTown = readTownPose(object);
  Fields fields(object.require("town"), "town");
  SceneLanes lanes = townLanes(fields, seed);
  for (std::vector<Vec3d>* lane : {&lanes.lane, &lanes.turns}) {
    for (Vec3d& p : *lane) p = worldFromTown * p;
  }
  return lanes;
}

Pose readLinkPose(const std::filesystem::path& path, const std::string& link, const Location& where) {
  const Value root = readSceneYaml(path);
  std::vector<DrawnValue> draws;
  for (const Value& item : objectsOf(root, 1, draws).items) {
    Fields object(item, "object");
    const Value* const file = object.find("file");
    if (file == nullptr || !lowerCase(file->text).ends_with(".urdf")) continue;
    for (const char* key : {"copies", "scale", "moving", "stand_on", "vary", "unit", "up"}) {
      if (!object.has(key)) continue;
      throw InputError(object.require(key).where, "a sensor is mounted on a link of this robot: leave out `{}`", key);
    }
    const std::filesystem::path folder = Fields(root, "scene").optionalPath("assets").value_or(std::filesystem::path());
    const std::filesystem::path urdf = folder.empty() ? resolvePath(*file, file->text) : folder / file->text;
    const Affine robotFrom = robotFromLink(urdf, readJoints(object), link);
    return object.pose() * Pose{fromMatrix(robotFrom.linear), robotFrom.translation};
  }
  throw InputError(where, "the vehicle's scene {} has no URDF file, which alone has links", path.string());
}

Ontology readSceneOntology(const std::filesystem::path& path) {
  const Value root = readSceneYaml(path);
  return readOntology(Fields(root, "scene").resource("ontology", "labels"));
}

Scene readScene(const std::filesystem::path& path, const SceneOptions& options) {
  const InputBudget budget;
  const Value root = readSceneYaml(path);
  Fields file(root, "scene");
  const std::string name = file.text("name", path.stem().string());
  file.text("ontology");
  const std::filesystem::path ontologyFile =
      options.ontology.empty() ? file.resource("ontology", "labels") : options.ontology;
  const std::filesystem::path materialsFile = file.resource("materials", "labels");
  const std::filesystem::path assetFolder = file.optionalPath("assets").value_or(std::filesystem::path());
  std::vector<Rule> rules;
  if (const Value* value = file.find("rules")) rules = readRules(*value);
  const Value& listedObjects = file.require("objects");
  if (listedObjects.kind != Value::Kind::Sequence || (listedObjects.items.empty() && !options.add)) {
    throw InputError(listedObjects.where, "objects must be a list of at least one object");
  }
  std::vector<DrawnValue> draws;
  const Value objects = objectsOf(root, options.seed, draws);

  SceneBuilder builder(name, options.seed, readOntology(ontologyFile),
                       readMaterials(materialsFile, options.wavelengthNm));
  ObjectPlacer placer(builder, options.seed);
  FileObjects fileObjects(builder, placer, std::move(rules), assetFolder, options.textures);
  std::map<std::string, std::uint32_t> primitiveMeshes;
  // If the scene has a town, all objects have random reflectances, also those listed before the town.
  const bool hasTown = findTown(objects) != nullptr;
  if (hasTown) builder.drawReflectances();
  for (const Value& value : objects.items) {
    Fields object(value, "object");
    const std::string kind = kindOf(object);
    if (kind == "file") fileObjects.add(object);
    if (kind == "primitive") addPrimitive(object, builder, placer, primitiveMeshes);
    if (kind != "town") continue;
    const Affine worldFromTown = readTownPose(object);
    Fields town(object.require("town"), "town");
    addTown(builder, town, options.seed, worldFromTown);
  }
  if (options.add) options.add(builder);
  Scene scene = builder.finish();
  scene.file = path;
  scene.procedural = hasTown || placer.random() || !draws.empty();
  scene.draws = std::move(draws);
  return scene;
}

}  // namespace scanmill
