#include "scenefile/file_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "assets/meshes/gltf/reader.h"
#include "assets/surveys/surveys.h"
#include "base/error.h"
#include "config/text.h"
#include "formats/cloud_file.h"
#include "rasters/raster.h"
#include "scenefile/survey_options.h"

namespace scanmill {
namespace {

// A clip of an animation is sampled at equal steps of at most kMoment or, if this would need more than kMostMoments
// steps, at kMostMoments longer steps.
constexpr double kMoment = 0.05;  // s
constexpr double kMostMoments = 48;

// Returns a key of a file with its options and rules. Objects with equal keys share their meshes.
std::string meshKey(const std::filesystem::path& file, const AssetOptions& asset, const Labelling& labelling) {
  // The path through symbolic links: two links to a file may have different textures beside them.
  const std::filesystem::path path = std::filesystem::absolute(file).lexically_normal();
  std::string key =
      fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}", path.string(), labelling.file, asset.metresPerUnit,
                  asset.unitStated, asset.up.value_or('-'), static_cast<int>(asset.alpha), asset.allowOutside,
                  asset.leaveOutMissing, labelling.things.text());
  key += '\n' + keyOf(asset.points, asset.heights);
  for (const std::filesystem::path& folder : asset.textureFolders) key += '\n' + folder.string();
  if (asset.clip) key += fmt::format("\n{}\n{}", asset.clip->clip, asset.clip->time);
  for (const Rule& r : labelling.rules) {
    for (const std::string& text : {describe(r), r.className, r.materialName}) {
      key += fmt::format("\n{}:{}", text.size(), text);
    }
    key += fmt::format("\n{} {}", r.within, r.drop);
    for (const std::optional<Between>& b : {r.height, r.slope, r.size}) {
      if (b) key += fmt::format(" {} {}", b->low, b->high);
    }
    if (r.box) {
      for (const Vec3d& c : {r.box->low, r.box->high}) key += fmt::format(" {} {} {}", c.x, c.y, c.z);
    }
  }
  return key;
}

}  // namespace

const std::vector<PlacedMesh>& FileMeshes::read(const std::filesystem::path& file, const AssetOptions& options,
                                                const Labelling& labelling, const Location& where) {
  const std::string key = meshKey(file, options, labelling);
  auto known = meshes_.find(key);
  if (known == meshes_.end()) {
    Asset asset = load(file, options, labelling, where);
    if (!asset.system.empty()) surveys_[key] = {file, asset.system, asset.ownMiddle, asset.origin};
    known = meshes_.emplace(key, addAsset(builder_, std::move(asset), labelling, where)).first;
  }
  return known->second;
}

void FileMeshes::compareSurveys(const std::filesystem::path& file, const AssetOptions& options,
                                const Labelling& labelling, const Vec3d& position, const Location& where) {
  const auto found = surveys_.find(meshKey(file, options, labelling));
  if (found == surveys_.end() || misfitTold_) return;
  const Survey& own = found->second;
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
  misfitTold_ = true;
  warn(fmt::format(
      "{}: {} and {} have the same position, {}, so that they do not fit: merge tiles by gdalbuildvrt, "
      "convert them to one system in metres by `gdalwarp -t_srs` or `pdal translate`, or give them positions "
      "of their own",
      where.text(), first.file.string(), own.file.string(), why));
}

// Returns the animation of a clip. All its moments use the materials of the first moment, so that textures are stored
// only once.
std::shared_ptr<const Animation> FileMeshes::playing(const std::filesystem::path& file, AssetOptions options,
                                                     Labelling labelling, const std::string& clip,
                                                     const Location& where) {
  std::shared_ptr<const Animation>& known = animations_[clip + '\n' + meshKey(file, options, labelling)];
  if (known != nullptr) return known;
  const auto animation = std::make_shared<Animation>();
  std::map<std::pair<std::uint32_t, std::string>, Material> materials;  // by index of the node and name of the material
  const auto addMoment = [&](double time) {
    options.clip = {clip, time};
    Asset moment = load(file, options, labelling, where);
    for (AssetPart& part : moment.parts) {
      const auto [first, isNew] = materials.emplace(std::pair{part.nodeIndex, part.material}, part.fileMaterial);
      if (!isNew) part.fileMaterial = first->second;
    }
    animation->meshes.push_back(addAsset(builder_, std::move(moment), labelling, where).front().mesh);
    options.textures = false;
    labelling.counted = true;
  };
  addMoment(0);  // the mesh of time 0 has the pose of the first key frame
  const auto [first, last] = gltf::clipSpan(file, clip);
  const double moments = std::clamp(std::ceil((last - first) / kMoment), 1.0, kMostMoments);
  for (int k = 1; k < moments; ++k) addMoment(first + (last - first) * k / moments);
  animation->period = std::max(last - first, 1e-3);
  animation->until = std::numeric_limits<double>::infinity();
  return known = animation;
}

// If some rule sets a material and no rule tests colours, the asset is first read without textures, and read again with
// textures only if some part shows its own texture. Decoding textures can cost more than all other work on the file,
// and materials of the library seldom use them.
Asset FileMeshes::load(const std::filesystem::path& file, const AssetOptions& options, const Labelling& labelling,
                       const Location& where) const {
  try {
    const auto any = [&](const auto& is) { return std::any_of(labelling.rules.begin(), labelling.rules.end(), is); };
    if (any([](const Rule& rule) { return !rule.colors.empty(); })) {
      AssetOptions colored = options;
      colored.textures = true;
      return readAsset(file, colored);
    }
    // Colours and intensities of surveys are stored as textures.
    if (isCloud(file) || isHeights(lowerExtension(file))) return readAsset(file, options);
    const bool mayDoWithout = any([](const Rule& rule) { return !rule.materialName.empty(); });
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

}  // namespace scanmill
