// Reads scene files (scenes/*.yaml), whose keys docs/keys.md lists.

#include "scenefile/scene_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/input_budget.h"
#include "base/random.h"
#include "config/distribution.h"
#include "config/file_kind.h"
#include "scenefile/file_objects.h"
#include "scenefile/object_placer.h"
#include "scenefile/placement.h"
#include "scenefile/primitive_objects.h"
#include "scenefile/rules.h"
#include "town/town.h"

namespace scanmill {
namespace {

// Returns which of the three kinds the object is. Throws InputError if it is none of them, or several.
std::string kindOf(const Fields& f) {
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

// Returns the pose of a town. Reads all keys of the object except `town`, which the caller reads.
Affine readTownPose(Fields& f) {
  f.require("town");
  f.text("name", "town");
  f.refuse({"scale", "copies"}, "is not for towns: give the town's length");
  const Placement placement = readPlacement(f);
  f.finish();
  return toAffine(placement.object.pose);
}
// Returns the object that is a town; null if there is none. Throws InputError for a second one.
const Value* findTown(const Value& objects) {
  const Value* town = nullptr;
  for (const Value& object : objects.items) {
    if (kindOf(Fields(object, "object")) != "town") continue;
    if (town != nullptr) throw InputError(object.where, "a scene can have only one town");
    town = &object;
  }
  return town;
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
  ObjectPlacer placer(builder, options.seed);
  FileObjects files(builder, placer, std::move(rules), assets, options.textures);
  PrimitiveObjects primitives(builder, placer);
  // The materials of a scene with a town vary from place to place, also those of objects listed before the town.
  const bool hasTown = findTown(objects) != nullptr;
  if (hasTown) builder.drawReflectances();
  for (const Value& value : objects.items) {
    Fields object(value, "object");
    const std::string kind = kindOf(object);
    if (kind == "file") files.add(object);
    if (kind == "primitive") primitives.add(object);
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
