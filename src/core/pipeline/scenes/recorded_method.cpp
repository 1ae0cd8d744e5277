// Methods that use a recording instead of tracing: one returns recorded hits, the other one samples recorded passes.

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/stage_clock.h"
#include "methods/depth_camera/depth_camera.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

// Throws InputError if a material index of the hits is too large for the recording's material table, which effects use.
void checkMaterials(const Recording& recording, const Shot& shot, const Hits& hits) {
  if (hits.material.empty() || !hits.roughness.empty()) return;
  const std::size_t tableIndex = recording.sequences[shot.scene].materials;
  const std::size_t materialCount = recording.materials[tableIndex].size();
  const std::uint16_t largestIndex = *std::ranges::max_element(hits.material);
  const bool anyHit = std::ranges::any_of(hits.range, [](float r) { return r < kMiss; });
  if (largestIndex < materialCount || !anyHit) return;
  throw InputError({(recording.folder / "recording.json").string()},
                   "/materials/{}: has {} materials, but {} of '{}' has the material index {}: list all "
                   "materials, or give the images roughness, metallic and retroreflectance",
                   tableIndex, materialCount, shot.sample, shot.sensorName, largestIndex);
}

// A method that returns the hits of a recording.
class RecordedHits : public Method {
 public:
  explicit RecordedHits(std::shared_ptr<const Recording> recording) : recording_(std::move(recording)) {}

  TraceAccount prepare(const Shot&) const override { return {}; }

  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    const WallTimer timer;
    const auto file = recording_->folder / recording_->shot(shot.sample, shot.sensorName).hits;
    readHits(file, channels, hits);
    if (hits.rings != shot.beams->rings || hits.columns != shot.beams->columns) {
      throw InputError({file.string()}, "holds {} x {} beams, but '{}' has {} x {}", hits.rings, hits.columns,
                       shot.sensorName, shot.beams->rings, shot.beams->columns);
    }
    checkMaterials(*recording_, shot, hits);
    return {{{"read_hits", timer.seconds()}}, {}};
  }

  std::vector<ModelledItem> modelled() const override {
    std::vector<ModelledItem> items = recording_->modelled;
    items.push_back({"hits", fmt::format("read from a recording that {} made", recording_->method)});
    return items;
  }
  std::uint64_t memoryBytes() const override { return 0; }

 private:
  std::shared_ptr<const Recording> recording_;
};

// A method that samples the passes of a recording.
class RecordedPasses : public Method {
 public:
  RecordedPasses(std::shared_ptr<const Recording> recording, Fields& options)
      : recording_(std::move(recording)), sampler_(makePassSampler(options)) {}

  TraceAccount prepare(const Shot& shot) const override { return sampler_->prepare(shot); }

  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    hits.reset(shot.beams->rings, shot.beams->columns, channels);
    TraceAccount account;
    for (const RecordedStep& recorded : recording_->shot(shot.sample, shot.sensorName).steps) {
      PassStep step{recorded.firstColumn, recorded.endColumn, recorded.worldFromRig, {}};
      const WallTimer timer;
      for (const std::string& image : recorded.images) {
        step.images.push_back(readImage(recording_->folder / image, sampler_->passes(channels)));
      }
      account.seconds["read_passes"] += timer.seconds();
      account += sampler_->sample(shot, step, hits);
    }
    checkMaterials(*recording_, shot, hits);
    return account;
  }

  std::vector<ModelledItem> modelled() const override {
    std::vector<ModelledItem> items = recording_->modelled;
    for (ModelledItem& item : sampler_->modelled()) items.push_back(std::move(item));
    return items;
  }
  std::uint64_t memoryBytes() const override { return 0; }

 private:
  // Reads the passes of a file. If the file stores surface parameters, reads them instead of materials: material ids
  // that are requested but not in the file are then 0.
  static PassImage readImage(const std::filesystem::path& file, PassChoice passes) {
    const PassChoice stored = passesIn(file);
    passes.surfaceParameters = stored.surfaceParameters;
    const bool lacksMaterials =
        passes.channels.has(Channel::Material) && stored.surfaceParameters && !stored.channels.has(Channel::Material);
    if (lacksMaterials) passes.channels = passes.channels.without(Channel::Material);
    PassImage image = readPasses(file, passes);
    if (lacksMaterials) image.planes.material.assign(image.planes.size(), 0);
    return image;
  }

  std::shared_ptr<const Recording> recording_;
  std::unique_ptr<DepthCamera> sampler_;
};

}  // namespace

std::unique_ptr<Method> makeRecordedMethod(const Pipeline& pipeline) {
  if (pipeline.recording->kind == RecordingKind::Hits) return std::make_unique<RecordedHits>(pipeline.recording);
  Value options;
  options.where = {pipeline.file.string()};
  if (pipeline.method.entry != nullptr && pipeline.method.entry->can.passes) options = pipeline.method.options;
  Fields fields(options, fmt::format("method {}", firstMethodThat(&MethodCapabilities::passes).name));
  return std::make_unique<RecordedPasses>(pipeline.recording, fields);
}

}  // namespace scanmill
