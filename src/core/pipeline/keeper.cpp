#include "pipeline/keeper.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>

#include "base/parallel.h"
#include "config/version.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"

namespace scanmill {

namespace {

template <class Work>
void timed(std::atomic<std::int64_t>& nanoseconds, const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  nanoseconds += std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

Channels keptChannels() {
  return Channel::Range | Channel::Instance | Channels(Channel::Semantic) | Channel::Material | Channel::Reflectance |
         Channel::Incidence;
}

void Keeper::open(const std::filesystem::path& hits, const std::filesystem::path& passes, bool overwrite) {
  if (!hits.empty()) hits_.emplace(hits, overwrite);
  if (!passes.empty()) passes_.emplace(passes, overwrite);
}

void Keeper::enter(std::size_t sequence, const Scene& scene, const Method& method) {
  if (!keeps()) return;
  camera_ = dynamic_cast<const DepthCamera*>(&method);
  if (passes_ && camera_ == nullptr) {
    throw InputError({plan_.pipeline().file.string()},
                     fmt::format("the method {} draws no passes that could be kept: take `method: depth_camera`",
                                 plan_.pipeline().methodName()));
  }
  const Sequence& own = plan_.pipeline().sequences[sequence];
  const bool sameScene = sequence > 0 && own.sameScene(plan_.pipeline().sequences[sequence - 1]);
  if (!sameScene || materials_.empty()) materials_.push_back(scene.materials);
  for (Material& material : materials_.back()) material.texture.reset();
  ontology_ = scene.ontology;
  sequences_.push_back(
      {own.scene, own.sceneSeed, own.trajectoryName, own.frames, static_cast<std::uint32_t>(materials_.size() - 1)});
  for (std::string& line : method.modelled()) {
    if (std::find(modelled_.begin(), modelled_.end(), line) == modelled_.end()) modelled_.push_back(std::move(line));
  }
}

void Keeper::leave() {
  camera_ = nullptr;
}

void Keeper::keep(const Shot& shot, Channels channels, Hits& hits) const {
  if (passes_) {
    hits.reset(shot.beams->rings, shot.beams->columns, channels);
    PassChoice choice = camera_->passes(channels);
    choice.look = channels.has(Channel::Material);
    keepPasses(shot, choice, [&](const PassStep& step) { camera_->sample(shot, step, hits); });
  }
  if (hits_) {
    const std::filesystem::path file = hits_->file(shot.sample, shot.sensorName, "hits.exr");
    timed(writingHits_, [&] { writeHits(file, hits); });
    hits_->add({shot.sample, shot.sensorName, shot.time, shot.worldFromSensor, file.filename().string(), {}});
  }
}

void Keeper::keepPasses(const Shot& shot, PassChoice choice, const std::function<void(const PassStep&)>& use) const {
  RecordedShot recorded{shot.sample, shot.sensorName, shot.time, shot.worldFromSensor, "", {}};
  camera_->draw(shot, choice, [&](PassStep&& step) {
    RecordedStep kept{step.firstColumn, step.endColumn, step.worldFromRig, {}};
    for (const PassImage& image : step.images) {
      const auto file = passes_->file(shot.sample, shot.sensorName,
                                      fmt::format("{}.{}.exr", recorded.steps.size(), image.camera.name));
      kept.images.push_back(file.filename().string());
    }
    timed(writingPasses_, [&] {
      parallelFor(step.images.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) writePasses(passes_->folder() / kept.images[i], step.images[i]);
      });
    });
    recorded.steps.push_back(std::move(kept));
    if (use) use(step);
  });
  passes_->add(recorded);
}

Recording Keeper::describe(RecordingKind kind) const {
  Recording recording;
  recording.kind = kind;
  recording.programVersion = kVersion;
  recording.method = plan_.pipeline().methodName();
  recording.ontology = ontology_;
  for (std::size_t s = 0; s < plan_.beams().size(); ++s) {
    const MountedSensor& sensor = plan_.pipeline().sensors[s];
    const BeamTable& beams = *plan_.beams()[s];
    recording.sensors.push_back({sensor.name, beams.rings, beams.columns, beamsHash(beams), sensor.vehicleFromSensor});
  }
  recording.sequences = sequences_;
  recording.materials = materials_;
  recording.modelled = modelled_;
  return recording;
}

std::map<std::string, double> Keeper::stageSeconds() const {
  std::map<std::string, double> seconds;
  if (hits_) seconds["write_hits"] = static_cast<double>(writingHits_) * 1e-9;
  if (passes_) seconds["write_passes"] = static_cast<double>(writingPasses_) * 1e-9;
  return seconds;
}

void Keeper::finish() {
  if (hits_) hits_->finish(describe(RecordingKind::Hits));
  if (passes_) passes_->finish(describe(RecordingKind::Passes));
}

}  // namespace scanmill
