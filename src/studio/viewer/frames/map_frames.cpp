#include <atomic>
#include <map>
#include <unordered_set>
#include <utility>

#include "base/append_new.h"
#include "base/error.h"
#include "pipeline/run/progress.h"
#include "viewer/frames/frame_source.h"

namespace scanmill {

namespace {

// Returns a number that identifies the voxel of a point. Each coordinate must be less than 2^20 voxels.
std::uint64_t voxelOf(const Vec3f& p, double voxelSize) {
  const auto index = [&](float coordinate) {
    return static_cast<std::uint64_t>(std::floor(double{coordinate} / voxelSize) + (1 << 20));
  };
  return index(p.x) << 42 | index(p.y) << 21 | index(p.z);
}

// Collects points. Of each voxel, the first point is kept. Since a voxel of double size consists of complete voxels,
// the points do not depend on when the voxels grow.
struct ThinnedMap {
  ViewScan map;
  double voxelSize = kFinestMapVoxel;  // m
  std::unordered_set<std::uint64_t> voxels;

  void add(const ViewScan& from, const Affine& mapFromScan, std::size_t mostPoints) {
    constexpr float kFarthest = 5e4F;    // largest distance of a point from the map's origin (m)
    std::vector<std::uint32_t> indices;  // indices of the points that are kept
    for (std::uint32_t i = 0; i < from.scan.size(); ++i) {
      const Vec3f position(mapFromScan * Vec3d(from.drawnPositions()[i]));
      if (!(length(position) < kFarthest) || !voxels.insert(voxelOf(position, voxelSize)).second) continue;
      map.scan.position.push_back(position);
      indices.push_back(i);
    }
    // Appends the values of the points that are kept. A column that a scan lacks is removed from the map.
    const auto append = [&](auto& values, const auto& added) {
      for (std::size_t k = 0; k < indices.size() && !added.empty(); ++k) values.push_back(added[indices[k]]);
      if (values.size() != map.scan.size()) values.clear();
    };
    visitTable(map.scan, [&](auto key, auto& values) { append(values, from.scan[key]); });
    append(map.error, from.error);
    if (map.name.empty()) map.name = from.name;
    map.method = from.method;
    map.errorTitle = from.errorTitle;
    map.whyNoError = from.whyNoError;
    if (map.scan.size() <= mostPoints) return;
    const ViewScan finer = std::exchange(map, {});
    voxels.clear();
    voxelSize *= 2;
    add(finer, {}, mostPoints);
  }
};

// Returns the index of the first sample of the only sequence whose name contains `name`; without one, see find().
std::size_t sampleOf(const FrameSource& samples, const std::string& name) {
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < samples.keys().size() && !name.empty(); ++i) {
    const std::string sequence = partsOfKey(samples.keys()[i]).sequence;
    if (sequence.find(name) == std::string::npos) continue;
    if (first && sequence != partsOfKey(samples.keys()[*first]).sequence) return samples.find(name);
    if (!first) first = i;
  }
  return first ? *first : samples.find(name);
}

// A source of one frame: the map of a sequence.
class MapFrames final : public FrameSource {
 public:
  MapFrames(std::shared_ptr<const FrameSource> samples, const std::string& name, std::size_t mostPoints)
      : samples_(std::move(samples)), sample_(sampleOf(*samples_, name)), mostPoints_(mostPoints) {
    const std::string& key = samples_->keys()[sample_];
    const std::string sequence = partsOfKey(key).sequence;
    keys_.push_back(sequence.empty() ? key : sequence);
  }

  std::string title() const override { return samples_->title() + ", map of " + keys_.front(); }
  const std::vector<std::string>& keys() const override { return keys_; }
  const Ontology* ontology() const override { return samples_->ontology(); }
  std::shared_ptr<const FrameSource> samples() const override { return samples_; }
  std::size_t find(const std::string& /*name*/) const override { return 0; }
  ViewFrame load(std::size_t frame) const override;
  void stop() const override { stopped_ = true; }
  std::vector<Pose> trajectory(std::size_t /*frame*/) const override { return samples_->trajectory(sample_); }
  std::optional<SceneChoice> scene(std::size_t /*frame*/, std::string& why) const override {
    return samples_->scene(sample_, why);
  }
  std::vector<std::uint16_t> classes() const override { return samples_->classes(); }

 private:
  std::shared_ptr<const FrameSource> samples_;
  std::size_t sample_;  // index of a sample of the sequence
  std::size_t mostPoints_;
  std::vector<std::string> keys_;  // the name of the sequence
  mutable std::atomic<bool> stopped_ = false;
};

ViewFrame MapFrames::load(std::size_t frame) const {
  ViewFrame view{.key = keys_.front(), .scans = {}, .problems = {}};
  const std::vector<Pose> poses = trajectory(frame);
  if (poses.empty()) {
    view.problems.push_back(samples_->title() + " does not say where its scans were made: they have no map");
    return view;
  }
  const Pose worldFromMap{fromYawPitchRoll(headingOf(poses.front().rotation), 0, 0), poses.front().translation};
  std::vector<std::size_t> frames;  // indices of the sequence's samples
  for (std::size_t i = 0; i < samples_->keys().size(); ++i) {
    const std::string& key = samples_->keys()[i];
    if (key == keys_.front() || partsOfKey(key).sequence == keys_.front()) frames.push_back(i);
  }
  std::map<std::pair<std::size_t, std::string>, ThinnedMap> maps;  // the keys are stores and methods
  Progress progress("map", frames.size(), "frames", "points", false);
  for (std::size_t k = 0; k < frames.size() && !stopped_; ++k) {
    const ViewFrame sample = samples_->load(frames[k]);
    std::size_t points = 0;
    for (const ViewScan& scan : sample.scans) {
      if (!scan.worldFromSensor) continue;
      const Affine mapFromScan = inverse(toAffine(worldFromMap)) * toAffine(*scan.worldFromSensor);
      maps[{scan.store, scan.method}].add(scan, mapFromScan, mostPoints_);
      points += scan.scan.size();
    }
    appendNew(sample.problems, view.problems);
    progress.advance(1, static_cast<double>(points));
  }
  for (auto& [storeAndMethod, thinned] : maps) {
    ViewScan& map = view.scans.emplace_back(std::move(thinned.map));
    map.worldFromSensor = worldFromMap;
    map.scan[kColumn].clear();     // beams of different samples must not seem to be the same beam
    map.scan[kRangeTrue].clear();  // true ranges are from other positions than the map's origin
  }
  return view;
}

}  // namespace

std::shared_ptr<const FrameSource> mapOf(std::shared_ptr<const FrameSource> samples, const std::string& name,
                                         std::size_t mostPoints) {
  if (samples->isScene()) throw InputError({samples->title()}, "is a scene: a map shows the samples of a dataset");
  return std::make_shared<MapFrames>(std::move(samples), name, mostPoints);
}

}  // namespace scanmill
