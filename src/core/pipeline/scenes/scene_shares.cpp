#include "pipeline/scenes/scene_shares.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "base/path.h"
#include "pipeline/plan/plan.h"
#include "scenefile/scene_file.h"

namespace scanmill {
namespace {

constexpr double kHeight = 1.73;  // height of the sensor above the lane (m)
constexpr double kBetween = 25;   // least distance between poses (m)
constexpr int kTries = 8;  // maximum number of scenes whose shares are measured; the best of these scenes is used
constexpr double kMostFactor = 40;
constexpr double kLeastFactor = 1.0 / 100;  // smaller factors are rounded to 0

std::shared_ptr<const BeamTable> coarseBeams() {
  auto beams = std::make_shared<BeamTable>();
  beams->model = "64 rings";
  beams->rings = 64;
  beams->columns = 360;
  beams->minRange = 1;
  beams->maxRange = 100;
  beams->period = 0.1;
  beams->azimuthOffset.assign(beams->rings, 0);
  beams->firingOffset.assign(beams->rings, 0);
  for (std::uint32_t r = 0; r < beams->rings; ++r) {
    beams->elevation.push_back(radians(-24.8 + 26.8 * r / (beams->rings - 1)));
  }
  fillBeams(*beams);
  return beams;
}

// Returns poses evenly spaced along a polyline, kHeight above it.
std::vector<Pose> posesAbove(const std::vector<Vec3d>& lane) {
  const Path path(lane);
  const int count = std::max(1, static_cast<int>(path.length() / kBetween));
  std::vector<Pose> poses;
  poses.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    poses.push_back(path.pose(path.length() * (k + 0.5) / count) * Pose{{}, {0, 0, kHeight}});
  }
  return poses;
}

// Returns how far the measured shares are outside of their bounds: the sum of the excesses, each divided by the upper
// bound; 0 if all shares are within their bounds.
double distanceOf(const std::vector<ShareBound>& bounds) {
  double sum = 0;
  for (const ShareBound& b : bounds)
    sum += std::max({0.0, b.least - b.found, b.found - b.most}) / std::max(b.most, 1e-6);
  return sum;
}

// The factor by which the supply of one kind of object is multiplied. The factor `low` gave too few hits, `high` too
// many; once both are known, the factor stays between them.
struct Dial {
  double factor = 1;
  std::optional<double> low, high;

  // Raises (`more`) or lowers the factor. `ratio`: the wanted share of hits divided by the measured share; used until
  // `low` and `high` are known.
  void turn(bool more, double ratio) {
    (more ? low : high) = factor;
    if (low && high) {
      factor = *low > 0 ? std::sqrt(*low * *high) : *high / 4;
    } else {
      factor *= more ? std::clamp(ratio, 1.5, 5.0) : std::clamp(ratio, 0.05, 0.5);
    }
    factor = factor < kLeastFactor ? 0 : std::min(factor, kMostFactor);
  }
};

// Adjusts the factors of the supplies whose shares of hits are outside of their bounds. A factor is not changed if one
// bound asks for more of the supply and another bound for less.
void turn(std::array<Dial, kSupplies>& dials, const std::vector<ShareBound>& bounds) {
  // Largest distance of the wanted share from the violated bound, as a fraction of the bound.
  constexpr double kInside = 0.15;
  for (std::size_t s = 0; s < kSupplies; ++s) {
    double more = 0;
    double less = 0;
    for (const ShareBound& b : bounds) {
      if (static_cast<std::size_t>(b.supply) != s || b.met()) continue;
      const double middle = (b.least + b.most) / 2;
      if (b.found < b.least) more = std::max(more, std::min(b.least * (1 + kInside), middle) / std::max(b.found, 1e-9));
      if (b.found > b.most) less = std::max(less, b.found / std::max(b.most * (1 - kInside), middle));
    }
    if (more > 0 && less == 0) dials[s].turn(true, more);
    if (less > 0 && more == 0) dials[s].turn(false, 1 / less);
  }
}

std::string inWords(const std::vector<ShareBound>& bounds) {
  std::string words;
  for (const ShareBound& b : bounds)
    words += fmt::format("{} {} {:.2g} %", words.empty() ? ";" : ",", b.name, 100 * b.found);
  return words;
}

}  // namespace

void measureShares(Scene& scene, const std::vector<Vec3d>& lane) {
  const auto method = makeReference(scene);
  std::map<std::uint16_t, std::uint64_t> met;
  std::uint64_t all = 0;
  Shot shot;
  shot.beams = coarseBeams();
  for (const Pose& pose : posesAbove(lane)) {
    shot.worldFromSensor = {pose};
    Hits hits;
    method->trace(shot, Channel::Semantic, hits);
    for (std::size_t ray = 0; ray < hits.rays(); ++ray) {
      if (!hits.hit(ray)) continue;
      ++met[hits.semantic[ray]];
      ++all;
    }
  }
  for (ShareBound& bound : scene.shares) {
    std::uint64_t of = 0;
    for (const std::uint16_t id : bound.classes) of += met[id];
    bound.found = all > 0 ? static_cast<double>(of) / static_cast<double>(all) : 0;
  }
}

Scene readSceneToShares(const std::filesystem::path& file, SceneOptions options) {
  Scene scene = readScene(file, options);
  if (scene.shares.empty()) return scene;
  // Shares are measured with the ontology that the scene file names, so that a different ontology for the labels does
  // not change the geometry.
  const std::filesystem::path labels = std::exchange(options.ontology, {});
  if (!labels.empty()) scene = readScene(file, options);
  const std::vector<Vec3d> lane = readSceneLanes(file, options.seed)->lane;
  std::array<Dial, kSupplies> dials;
  SupplyFactors best = options.supply;
  std::vector<ShareBound> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (int tried = 1;; ++tried) {
    measureShares(scene, lane);
    const double distance = distanceOf(scene.shares);
    if (distance < least) {
      least = distance;
      best = options.supply;
      nearest = scene.shares;
    }
    if (distance == 0 || tried == kTries) break;
    turn(dials, scene.shares);
    SupplyFactors next{};
    for (std::size_t s = 0; s < kSupplies; ++s) next[s] = dials[s].factor;
    if (next == options.supply) break;
    options.supply = next;
    scene = readScene(file, options);
  }
  if (options.supply != best || !labels.empty()) {
    options.supply = best;
    options.ontology = labels;
    scene = readScene(file, options);
  }
  scene.shares = nearest;
  scene.about += inWords(scene.shares);
  return scene;
}

std::vector<std::string> shareWarnings(const Scene& scene) {
  std::vector<std::string> lines;
  for (const ShareBound& b : scene.shares) {
    if (b.met()) continue;
    lines.push_back(fmt::format(
        "scene {} seed {}: {} is {:.2g} % of the hits of a sensor above the lane, {} the {:.3g} % asked for, for all "
        "values of the factor `{}`: widen the bounds, or leave this seed out",
        scene.file.stem().string(), scene.seed, b.name, 100 * b.found, b.found < b.least ? "less than" : "more than",
        100 * (b.found < b.least ? b.least : b.most), nameOf(b.supply)));
  }
  return lines;
}

}  // namespace scanmill
