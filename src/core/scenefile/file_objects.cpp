#include "scenefile/file_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "assets/asset_kinds.h"
#include "assets/meshes/gltf/reader.h"
#include "base/error.h"
#include "base/file.h"
#include "formats/cloud_file.h"
#include "rasters/raster.h"
#include "scene/ontology.h"
#include "scenefile/concepts.h"

namespace scanmill {
namespace {

struct Clip {
  std::string name;
  std::optional<double> time;  // time (s) at which the clip is frozen; absent: the clip loops
};

// Reads the key `animation`: {clip: NAME, time_s: t}; nothing if the key is absent.
std::optional<Clip> clipOf(Fields& f) {
  const Value* const value = f.find("animation");
  if (value == nullptr) return std::nullopt;
  Fields fields(*value, "animation");
  fields.also({"clip", "time_s"});
  Clip clip{fields.text("clip"), std::nullopt};
  if (fields.has("time_s")) clip.time = fields.number("time_s", {0, 1e6});
  fields.finish();
  return clip;
}

// A clip of an animation is sampled at equal steps of at most kStep or, if this would need more than kMostSteps steps,
// at kMostSteps longer steps. Chosen by eye.
constexpr double kStep = 0.05;  // s
constexpr double kMostSteps = 48;

PointOptions readPointOptions(const Value& value) {
  Fields fields(value, "points");
  fields.also({"spacing", "cover", "radius", "reflectance", "full", "labels"}).finish();
  PointOptions options;
  if (fields.has("spacing")) options.spacing = fields.number("spacing", {1e-4, 1e3});
  options.surfels.cover = fields.number("cover", {0.1, 10}, options.surfels.cover);
  constexpr Range kRadii{1e-4, 100};  // m
  if (const Value* radius = fields.find("radius")) {
    const bool isNumber = radius->kind == Value::Kind::Scalar;
    const Range range = isNumber ? Range{fields.number("radius", kRadii), fields.number("radius", kRadii)}
                                 : *fields.range("radius", kRadii);
    options.surfels.radius = {range.low, range.high};
  }
  using Reflectance = PointOptions::Reflectance;
  constexpr std::pair<const char*, Reflectance> kSources[]{{"auto", Reflectance::Auto},
                                                           {"intensity", Reflectance::Intensity},
                                                           {"color", Reflectance::Color},
                                                           {"none", Reflectance::None}};
  options.reflectance = namedChoice(fields, "reflectance", kSources, Reflectance::Auto).second;
  if (fields.has("full")) options.full = fields.number("full", {1e-9, 1e9});
  if (const auto file = fields.optionalResource("labels", "labels")) {
    for (const SemanticClass& c : readOntology(*file).classes) options.labels[c.id] = c.name;
  }
  return options;
}

HeightOptions readHeightOptions(const Value& value) {
  Fields fields(value, "heights");
  fields.also({"every", "within", "classes", "image"}).finish();
  HeightOptions options{.every = static_cast<int>(fields.integer("every", 1, 10'000, 1))};
  if (const Value* within = fields.find("within")) options.within = readRectangle(*within, "within");
  options.classes = fields.optionalPath("classes").value_or("");
  options.image = fields.optionalPath("image").value_or("");
  return options;
}

// Reads the keys `points` (for point clouds) and `heights` (for height rasters) of an object into `asset`, if present.
// Throws InputError for an invalid value, and for a key that does not fit the kind of the file.
void readSurveyOptions(Fields& object, const std::filesystem::path& file, AssetOptions& asset) {
  const bool cloud = isCloud(file);
  if (const Value* points = object.find("points")) {
    if (!cloud)
      throw InputError(
          points->where,
          "points is only for point clouds: .las, .pcd, .drc, .csv, .xyz, .asc of points, and .ply without faces");
    asset.points = readPointOptions(*points);
  }
  if (const Value* heights = object.find("heights")) {
    if (cloud || readerOf(file) != AssetReader::Heights)
      throw InputError(heights->where, "heights is only for rasters, such as .tif");
    asset.heights = readHeightOptions(*heights);
  }
}

}  // namespace

FileObjects::FileObjects(SceneBuilder& builder, ObjectPlacer& placer, std::vector<Rule> sceneRules,
                         std::filesystem::path assetFolder, bool textures)
    : builder_(builder),
      placer_(placer),
      sceneRules_(std::move(sceneRules)),
      assetFolder_(std::move(assetFolder)),
      textures_(textures),
      meshes_(builder) {
  checkNames(sceneRules_);
}

std::filesystem::path FileObjects::assetPath(const std::string& name, const Value& value) const {
  if (name.empty()) throw InputError(value.where, "file is empty");
  if (assetFolder_.empty() || std::filesystem::path(name).is_absolute()) return resolvePath(value, name);
  return assetFolder_ / name;
}

// Throws InputError if a rule has an unknown class or material, so that a typing error is found even if the rule
// matches nothing.
void FileObjects::checkNames(const std::vector<Rule>& rules) const {
  for (const Rule& rule : rules) {
    if (!rule.className.empty()) requireClass(builder_.ontology(), rule.className, rule.where);
    if (!rule.materialName.empty()) builder_.library().require(rule.materialName, rule.where);
  }
}

// Returns the object's file; for {one_of: [...]}, every listed file and every file in a listed folder.
std::vector<FileObjects::NamedFile> FileObjects::filesOf(Fields& object) const {
  const Value& value = object.require("file");
  if (value.kind == Value::Kind::Sequence) {
    throw InputError(value.where,
                     "file must be one file: write an object for each, or {one_of: [...]}, from which each copy is "
                     "one at random");
  }
  if (value.kind != Value::Kind::Map) {
    const std::string name = object.text("file");
    const std::filesystem::path path = assetPath(name, value);
    if (isFolder(path)) {
      throw InputError(value.where,
                       "'{}' is a folder: name a file in it, or write {{one_of: {}}}, from "
                       "which each copy is one at random",
                       path.string(), name);
    }
    return {{path, name}};
  }
  Fields choice(value, "file");
  choice.also({"one_of"}).finish();
  std::vector<NamedFile> files;
  for (const std::string& name : choice.texts("one_of")) {
    const std::filesystem::path path = assetPath(name, value);
    if (!isFolder(path)) {
      files.emplace_back(path, name);
      continue;
    }
    const std::vector<std::filesystem::path> folderFiles = assetsIn(path);
    if (folderFiles.empty()) throw InputError(value.where, "'{}' is a folder without 3D files", path.string());
    for (const std::filesystem::path& file : folderFiles) {
      files.emplace_back(file, (std::filesystem::path(name) / file.lexically_relative(path)).string());
    }
  }
  if (files.empty()) throw InputError(value.where, "one_of names no file");
  return files;
}

std::map<std::string, double> readJoints(Fields& object) {
  std::map<std::string, double> joints;
  const Value* const value = object.find("joints");
  if (value == nullptr) return joints;
  if (value->kind != Value::Kind::Map) {
    throw InputError(value->where, "joints must be a map from names of joints to positions (rad or m)");
  }
  for (const Value::Entry& entry : value->entries) joints[entry.key] = readNumber(entry.value, "joints." + entry.key);
  return joints;
}

// Reads those options of AssetOptions that apply to all kinds of files.
AssetOptions FileObjects::assetOptions(Fields& object) const {
  AssetOptions options;
  options.textures = textures_;
  options.metresPerUnit = object.number("unit", {1e-9, 1e9}, 1.0);
  options.unitStated = object.has("unit");
  if (object.has("up")) options.up = object.choice("up", {"x", "y", "z"}, "")[0];
  const std::string alpha = object.choice("alpha", {"auto", "ignore", "test"}, "auto");
  if (alpha != "auto") options.alpha = alpha == "test" ? AlphaUse::Test : AlphaUse::Ignore;
  options.allowOutside = object.boolean("allow_outside", false);
  options.leaveOutMissing = object.choice("missing", {"refuse", "leave_out"}, "refuse") == "leave_out";
  options.joints = readJoints(object);
  for (const std::string& name : object.texts("textures")) {
    options.textureFolders.push_back(assetPath(name, object.require("textures")));
    if (!isFolder(options.textureFolders.back())) {
      throw InputError(object.require("textures").where, "textures: '{}' is no folder",
                       options.textureFolders.back().string());
    }
  }
  return options;
}

// Returns all rules for an object in order of precedence: first its own rules, then one rule with its class and
// material, then the scene's rules.
std::vector<Rule> FileObjects::rulesOf(Fields& object) const {
  std::vector<Rule> rules;
  if (const Value* objectRules = object.find("rules")) rules = readRules(*objectRules);
  Rule shorthand;
  if (const Value* value = object.find("class")) {
    shorthand.where = value->where;
    shorthand.className = object.text("class");
  }
  if (const Value* value = object.find("material")) {
    if (shorthand.className.empty()) shorthand.where = value->where;
    shorthand.materialName = object.text("material");
  }
  if (!shorthand.className.empty() || !shorthand.materialName.empty()) rules.push_back(std::move(shorthand));
  checkNames(rules);
  rules.insert(rules.end(), sceneRules_.begin(), sceneRules_.end());
  return rules;
}

// Returns each combination of a file of the object and one of `materials`, which come from the key `vary`; without
// materials, each file once. Each copy of the object gets one of these combinations at random.
std::vector<LabelledFile> FileObjects::variantsOf(Fields& object, const std::vector<NamedFile>& files,
                                                  const std::vector<std::string>& materials) const {
  const AssetOptions asset = assetOptions(object);
  const std::vector<Rule> rules = rulesOf(object);
  std::vector<LabelledFile> variants;
  for (const auto& [file, name] : files) {
    LabelledFile variant{file, asset, {}};
    const bool cloud = isCloud(file);
    variant.labelling.file = name;
    variant.labelling.things = readThingBounds(object, cloud ? ThingBounds::By::Node : ThingBounds::By::Object);
    variant.labelling.things.byClass = cloud;
    variant.labelling.rules = rules;
    readSurveyOptions(object, file, variant.asset);
    for (const std::string& material : materials) {
      Rule materialRule;
      materialRule.where = object.require("vary").where;
      materialRule.materialName = material;
      builder_.library().require(material, materialRule.where);
      variants.push_back(variant);
      variants.back().labelling.rules.insert(variants.back().labelling.rules.begin(), std::move(materialRule));
    }
    if (materials.empty()) variants.push_back(std::move(variant));
  }
  return variants;
}

// A looping clip is placed as an animation; other objects are placed as the meshes of their variants.
void FileObjects::add(Fields& object) {
  const Location& where = object.require("file").where;
  const std::vector<NamedFile> files = filesOf(object);
  const std::string name = object.text("name", files.front().first.stem().string());
  Copies copies = placer_.read(object);
  std::vector<LabelledFile> variants = variantsOf(object, files, copies.arrangement.materials());
  const std::optional<Clip> clip = clipOf(object);
  object.finish();

  if (clip && variants.size() > 1) {
    throw InputError(object.require("animation").where, "animation is for objects of one file, which has the clip");
  }
  if (clip && !clip->time) {
    const ThingBounds& things = variants.front().labelling.things;
    if (things.by == ThingBounds::By::Part) {
      throw InputError(
          things.where,
          "the connected parts of a playing clip can change at any time: give `instances` node, object or a pattern");
    }
    const std::shared_ptr<const Animation> animation = meshes_.playing(variants.front(), clip->name, where);
    if (animation->meshes.size() > 1) copies.animation = animation;
    return placer_.place(animation->meshes.front(), name, copies, object.where());
  }
  if (clip) variants.front().asset.clip = {clip->name, *clip->time};
  const auto meshesOf = [&](std::size_t variant) -> const std::vector<PlacedMesh>& {
    return meshes_.read(variants[variant], where);
  };
  placer_.place(Variants{variants.size(), meshesOf}, name, copies, object.where());
  meshes_.compareSurveys(variants.front(), copies.placement.object.pose.translation, where);
}

// Returns the cache's entry for a file with these options and rules; adds an empty entry if there is none.
FileMeshes::Entry& FileMeshes::entryOf(const LabelledFile& labelled) {
  // Symbolic links are not resolved: two links to a file may have different textures beside them.
  std::list<Entry>& entries = cache_[std::filesystem::absolute(labelled.file).lexically_normal()];
  const auto entry = std::ranges::find_if(entries, [&](const Entry& e) {
    return e.labelled.asset == labelled.asset && e.labelled.labelling == labelled.labelling;
  });
  return entry != entries.end() ? *entry : entries.emplace_back(Entry{.labelled = labelled});
}

const std::vector<PlacedMesh>& FileMeshes::read(const LabelledFile& labelled, const Location& where) {
  Entry& entry = entryOf(labelled);
  if (entry.meshes.empty()) {
    Asset asset = load(labelled, where);
    if (!asset.system.empty()) entry.survey = Survey{labelled.file, asset.system, asset.ownMiddle, asset.origin};
    entry.meshes = addAsset(builder_, std::move(asset), labelled.labelling, where);
  }
  return entry.meshes;
}

void FileMeshes::compareSurveys(const LabelledFile& labelled, const Vec3d& position, const Location& where) {
  const Entry& entry = entryOf(labelled);
  if (!entry.survey || misfitReported_) return;
  const Survey& survey = *entry.survey;
  const Survey& first = *firstSurveys_.try_emplace({position.x, position.y}, &survey).first->second;
  if (first.system == survey.system) return;
  std::string misfit =
      fmt::format("{} around a middle of its own ({} and {})",
                  first.ownMiddle && survey.ownMiddle ? "each" : "one of them", first.system, survey.system);
  if (!first.ownMiddle && !survey.ownMiddle) {
    constexpr double kLeastShift = 10;  // m; two realisations of the same system differ by less
    const double shift = shiftBetween(first.system, survey.system, survey.origin.x, survey.origin.y);
    if (shift < kLeastShift) return;
    misfit = fmt::format("in coordinate systems that differ by {:.0f} m there", shift);
  }
  misfitReported_ = true;
  warn(
      "{}: {} and {} have the same position, {}, so that they do not fit: merge tiles by gdalbuildvrt, convert them "
      "to one system in metres by `gdalwarp -t_srs` or `pdal translate`, or give them positions of their own",
      where.text(), first.file.string(), survey.file.string(), misfit);
}

// Returns the animation of a clip. The meshes of all moments use the materials of the first moment, so that textures
// are stored only once.
std::shared_ptr<const Animation> FileMeshes::playing(LabelledFile labelled, const std::string& clip,
                                                     const Location& where) {
  labelled.asset.clip = {clip, 0};
  std::shared_ptr<const Animation>& cached = entryOf(labelled).animation;
  if (cached != nullptr) return cached;
  const auto animation = std::make_shared<Animation>();
  std::map<std::pair<std::uint32_t, std::string>, Material> materials;  // by index of the node and name of the material
  const auto addMoment = [&](double time) {
    labelled.asset.clip->time = time;
    Asset moment = load(labelled, where);
    for (AssetPart& part : moment.parts) {
      const auto [stored, isNew] = materials.emplace(std::pair{part.nodeIndex, part.material}, part.fileMaterial);
      if (!isNew) part.fileMaterial = stored->second;
    }
    animation->meshes.push_back(addAsset(builder_, std::move(moment), labelled.labelling, where).front().mesh);
    labelled.asset.textures = false;
    labelled.labelling.counted = true;
  };
  addMoment(0);  // the mesh of time 0 has the pose of the first key frame
  const auto [first, last] = gltf::clipSpan(labelled.file, clip);
  const double stepCount = std::clamp(std::ceil((last - first) / kStep), 1.0, kMostSteps);
  for (int k = 1; k < stepCount; ++k) addMoment(first + (last - first) * k / stepCount);
  constexpr double kLeastPeriod = 1e-3;  // s; a clip of one key frame has no length
  animation->period = std::max(last - first, kLeastPeriod);
  animation->until = std::numeric_limits<double>::infinity();
  return cached = animation;
}

// If some rule sets a material and no rule tests colours, the asset is first read without textures, and read again with
// textures only if some part shows its own texture. Decoding textures can cost more than all other work on the file,
// and materials of the library seldom show a file's texture.
Asset FileMeshes::load(const LabelledFile& labelled, const Location& where) const {
  const std::filesystem::path& file = labelled.file;
  const AssetOptions& options = labelled.asset;
  try {
    const auto anyRule = [&](const auto& condition) {
      return std::ranges::any_of(labelled.labelling.rules, condition);
    };
    if (anyRule([](const Rule& rule) { return !rule.colors.empty(); })) {
      AssetOptions colored = options;
      colored.textures = true;
      return readAsset(file, colored);
    }
    // Surveys are read with textures, which store their colours and intensities.
    if (isCloud(file) || readerOf(file) == AssetReader::Heights) return readAsset(file, options);
    const bool rulesSetMaterials = anyRule([](const Rule& rule) { return !rule.materialName.empty(); });
    if (!options.textures || !rulesSetMaterials) return readAsset(file, options);
    AssetOptions untextured = options;
    untextured.textures = false;
    Asset asset = readAsset(file, untextured);
    if (showsTextures(builder_, asset, labelled.labelling)) asset = readAsset(file, options);
    return asset;
  } catch (const InputError& e) {
    throw InputError(where, e.what());
  }
}

}  // namespace scanmill
