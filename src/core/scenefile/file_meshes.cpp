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
#include "scenefile/placement.h"
#include "scenefile/rules.h"

namespace scanmill {
namespace {

// A clip of an animation is sampled at equal steps of at most kMoment or, if this would need more than kMostMoments
// steps, at kMostMoments longer steps.
constexpr double kMoment = 0.05;  // s
constexpr double kMostMoments = 48;

PointOptions readPointOptions(const Value& value) {
  Fields f(value, "points");
  f.also({"spacing", "neighbors", "cover", "radius", "reflectance", "full", "labels"}).finish();
  PointOptions options;
  if (f.has("spacing")) options.spacing = f.number("spacing", {1e-4, 1e3});
  options.surfels.neighbors = static_cast<int>(f.integer("neighbors", 3, 100, options.surfels.neighbors));
  options.surfels.cover = f.number("cover", {0.1, 10}, options.surfels.cover);
  constexpr Range kRadii{1e-4, 100};  // m
  if (const Value* radius = f.find("radius")) {
    const bool one = radius->kind == Value::Kind::Scalar;
    const Range ends = one ? Range{f.number("radius", kRadii), f.number("radius", kRadii)} : *f.range("radius", kRadii);
    options.surfels.radius = {ends.low, ends.high};
  }
  using Reflectance = PointOptions::Reflectance;
  constexpr std::pair<const char*, Reflectance> kSources[]{{"auto", Reflectance::Auto},
                                                           {"intensity", Reflectance::Intensity},
                                                           {"color", Reflectance::Color},
                                                           {"none", Reflectance::None}};
  options.reflectance = namedChoice(f, "reflectance", kSources, Reflectance::Auto).second;
  if (f.has("full")) options.full = f.number("full", {1e-9, 1e9});
  if (const auto file = f.optionalResource("labels", "labels")) {
    for (const SemanticClass& c : readOntology(*file).classes) options.labels[c.id] = c.name;
  }
  return options;
}

HeightOptions readHeightOptions(const Value& value) {
  Fields f(value, "heights");
  f.also({"every", "within", "classes", "image"}).finish();
  HeightOptions options;
  options.every = static_cast<int>(f.integer("every", 1, 10'000, 1));
  if (const Value* within = f.find("within")) options.within = readRectangle(*within, "within");
  options.classes = f.optionalPath("classes").value_or("");
  options.image = f.optionalPath("image").value_or("");
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

FileMeshes::Known& FileMeshes::knownOf(const LabelledFile& from) {
  // The path is not that behind symbolic links: two links to a file may have different textures beside them.
  std::list<Known>& all = known_[std::filesystem::absolute(from.file).lexically_normal()];
  const auto found = std::ranges::find_if(all, [&](const Known& known) {
    return known.from.asset == from.asset && known.from.labelling == from.labelling;
  });
  return found != all.end() ? *found : all.emplace_back(Known{from, {}, {}, nullptr});
}

const std::vector<PlacedMesh>& FileMeshes::read(const LabelledFile& from, const Location& where) {
  Known& known = knownOf(from);
  if (known.meshes.empty()) {
    Asset asset = load(from, where);
    if (!asset.system.empty()) known.survey = Survey{from.file, asset.system, asset.ownMiddle, asset.origin};
    known.meshes = addAsset(builder_, std::move(asset), from.labelling, where);
  }
  return known.meshes;
}

void FileMeshes::compareSurveys(const LabelledFile& from, const Vec3d& position, const Location& where) {
  const Known& found = knownOf(from);
  if (!found.survey || misfitReported_) return;
  const Survey& own = *found.survey;
  const Survey& first = *firsts_.try_emplace({position.x, position.y}, &own).first->second;
  if (first.system == own.system) return;
  constexpr double kFits = 10;  // m, more than between two realisations of the same system
  std::string why = fmt::format("{} around a middle of its own ({} and {})",
                                first.ownMiddle && own.ownMiddle ? "each" : "one of them", first.system, own.system);
  if (!first.ownMiddle && !own.ownMiddle) {
    const double shift = shiftBetween(first.system, own.system, own.origin.x, own.origin.y);
    if (shift < kFits) return;
    why = fmt::format("in coordinate systems that differ by {:.0f} m there", shift);
  }
  misfitReported_ = true;
  warn(fmt::format(
      "{}: {} and {} have the same position, {}, so that they do not fit: merge tiles by gdalbuildvrt, "
      "convert them to one system in metres by `gdalwarp -t_srs` or `pdal translate`, or give them positions "
      "of their own",
      where.text(), first.file.string(), own.file.string(), why));
}

// Returns the animation of a clip. All its moments use the materials of the first moment, so that textures are stored
// only once.
std::shared_ptr<const Animation> FileMeshes::playing(LabelledFile from, const std::string& clip,
                                                     const Location& where) {
  from.asset.clip = {clip, 0};
  std::shared_ptr<const Animation>& known = knownOf(from).animation;
  if (known != nullptr) return known;
  const auto animation = std::make_shared<Animation>();
  std::map<std::pair<std::uint32_t, std::string>, Material> materials;  // by index of the node and name of the material
  const auto addMoment = [&](double time) {
    from.asset.clip->time = time;
    Asset moment = load(from, where);
    for (AssetPart& part : moment.parts) {
      const auto [first, isNew] = materials.emplace(std::pair{part.nodeIndex, part.material}, part.fileMaterial);
      if (!isNew) part.fileMaterial = first->second;
    }
    animation->meshes.push_back(addAsset(builder_, std::move(moment), from.labelling, where).front().mesh);
    from.asset.textures = false;
    from.labelling.counted = true;
  };
  addMoment(0);  // the mesh of time 0 has the pose of the first key frame
  const auto [first, last] = gltf::clipSpan(from.file, clip);
  const double moments = std::clamp(std::ceil((last - first) / kMoment), 1.0, kMostMoments);
  for (int k = 1; k < moments; ++k) addMoment(first + (last - first) * k / moments);
  animation->period = std::max(last - first, 1e-3);
  animation->until = std::numeric_limits<double>::infinity();
  return known = animation;
}

// If some rule sets a material and no rule tests colours, the asset is first read without textures, and read again with
// textures only if some part shows its own texture. Decoding textures can cost more than all other work on the file,
// and materials of the library seldom use them.
Asset FileMeshes::load(const LabelledFile& from, const Location& where) const {
  const std::filesystem::path& file = from.file;
  const AssetOptions& options = from.asset;
  try {
    const auto any = [&](const auto& is) { return std::ranges::any_of(from.labelling.rules, is); };
    if (any([](const Rule& rule) { return !rule.colors.empty(); })) {
      AssetOptions colored = options;
      colored.textures = true;
      return readAsset(file, colored);
    }
    // Colours and intensities of surveys are stored as textures.
    if (isCloud(file) || readerOf(file) == AssetReader::Heights) return readAsset(file, options);
    const bool mayDoWithout = any([](const Rule& rule) { return !rule.materialName.empty(); });
    if (!options.textures || !mayDoWithout) return readAsset(file, options);
    AssetOptions plain = options;
    plain.textures = false;
    Asset asset = readAsset(file, plain);
    if (showsTextures(builder_, asset, from.labelling)) asset = readAsset(file, options);
    return asset;
  } catch (const InputError& e) {
    throw InputError(where, e.what());
  }
}

}  // namespace scanmill
