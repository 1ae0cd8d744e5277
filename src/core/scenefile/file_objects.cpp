#include "scenefile/file_objects.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "assets/asset_kinds.h"
#include "assets/surveys/surveys.h"
#include "base/file.h"
#include "formats/cloud_file.h"
#include "scenefile/concepts.h"

namespace scanmill {
namespace {

// A clip of an animated file.
struct Clip {
  std::string name;
  std::optional<double> time;  // s, at which the clip is frozen; absent: it loops
};

// Reads {clip: NAME, time_s: t}.
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

// Throws InputError for an unknown class or material of a rule, so that a typing error is found even if the rule
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
  std::vector<NamedFile> files;
  for (const std::string& name : choice.texts("one_of")) {
    const std::filesystem::path path = assetPath(name, value);
    if (!isFolder(path)) {
      files.emplace_back(path, name);
      continue;
    }
    const std::vector<std::filesystem::path> folderFiles = assetsIn(path);
    if (folderFiles.empty())
      throw InputError(value.where, fmt::format("'{}' is a folder without 3D files", path.string()));
    for (const std::filesystem::path& file : folderFiles) {
      files.emplace_back(file, (std::filesystem::path(name) / file.lexically_relative(path)).string());
    }
  }
  if (files.empty()) throw InputError(value.where, "one_of names no file");
  return files;
}

// Reads the keys that say how a file becomes an asset, whatever its kind.
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
  for (const std::string& name : object.texts("textures")) {
    options.textureFolders.push_back(assetPath(name, object.require("textures")));
    if (!isFolder(options.textureFolders.back())) {
      throw InputError(object.require("textures").where,
                       fmt::format("textures: '{}' is no folder", options.textureFolders.back().string()));
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

// Returns each file of the object with each of the `materials` of the key `vary` (once, if there are none): a copy of
// the object gets one of these at random.
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
    return placer_.place(std::vector<PlacedMesh>{{animation->meshes.front(), {}, {}}}, name, copies, object.where());
  }
  if (clip) variants.front().asset.clip = {clip->name, *clip->time};
  const auto meshesOf = [&](std::size_t variant) -> const std::vector<PlacedMesh>& {
    return meshes_.read(variants[variant], where);
  };
  placer_.place(Variants{variants.size(), meshesOf}, name, copies, object.where());
  meshes_.compareSurveys(variants.front(), copies.placement.object.pose.translation, where);
}

}  // namespace scanmill
