#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "assets/asset_kinds.h"
#include "assets/meshes/gltf/reader.h"
#include "assets/surveys/surveys.h"
#include "base/error.h"
#include "config/fields.h"
#include "formats/cloud_file.h"
#include "rasters/raster.h"
#include "scene/ontology.h"
#include "scenefile/file_objects.h"
#include "scenefile/rules.h"

namespace scanmill {
namespace {

// A clip of an animation is sampled at equal steps of at most kStep or, if this would need more than kMostSteps steps,
// at kMostSteps longer steps. Chosen by eye.
constexpr double kStep = 0.05;  // s
constexpr double kMostSteps = 48;

PointOptions readPointOptions(const Value& value) {
  Fields fields(value, "points");
  fields.also({"spacing", "neighbors", "cover", "radius", "reflectance", "full", "labels"}).finish();
  PointOptions options;
  if (fields.has("spacing")) options.spacing = fields.number("spacing", {1e-4, 1e3});
  options.surfels.neighbors = static_cast<int>(fields.integer("neighbors", 3, 100, options.surfels.neighbors));
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
  HeightOptions options;
  options.every = static_cast<int>(fields.integer("every", 1, 10'000, 1));
  if (const Value* within = fields.find("within")) options.within = readRectangle(*within, "within");
  options.classes = fields.optionalPath("classes").value_or("");
  options.image = fields.optionalPath("image").value_or("");
  return options;
}

}  // namespace

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

// Returns the cache's entry of a file with its options and rules, which is new and empty if there was none.
FileMeshes::Entry& FileMeshes::entryOf(const LabelledFile& labelled) {
  // The path is not that behind symbolic links: two links to a file may have different textures beside them.
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
    constexpr double kLeastShift = 10;  // m, more than between two realisations of the same system
    const double shift = shiftBetween(first.system, survey.system, survey.origin.x, survey.origin.y);
    if (shift < kLeastShift) return;
    misfit = fmt::format("in coordinate systems that differ by {:.0f} m there", shift);
  }
  misfitReported_ = true;
  warn(fmt::format(
      "{}: {} and {} have the same position, {}, so that they do not fit: merge tiles by gdalbuildvrt, "
      "convert them to one system in metres by `gdalwarp -t_srs` or `pdal translate`, or give them positions "
      "of their own",
      where.text(), first.file.string(), survey.file.string(), misfit));
}

// Returns the animation of a clip. All its moments use the materials of the first moment, so that textures are stored
// only once.
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
// and materials of the library seldom use them.
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
    // Colours and intensities of surveys are stored as textures.
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
