#include "pipeline/run/recorder.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/append_new.h"
#include "base/parallel.h"
#include "config/value.h"
#include "config/version.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"

namespace scanmill {

Channels recordedChannels() {
  return channelsThat(&ChannelRow::recorded);
}

void Recorder::open(const std::filesystem::path& folder, bool overwrite) {
  if (!folder.empty()) writer_.emplace(folder, overwrite);
}

void Recorder::enter(std::size_t sequence, const Scene& scene, const Method& method) {
  if (!records()) return;
  const std::scoped_lock lock(mutex_);
  if (entered_.contains(sequence)) return;
  const Sequence& recorded = plan_.pipeline.sequences[sequence];
  Entered& entered = entered_[sequence];
  entered.record = {.scene = recorded.scene,
                    .seed = recorded.sceneSeed,
                    .trajectory = recorded.trajectoryName,
                    .frames = recorded.frames};
  for (const Value& item : recorded.without) entered.record.without.push_back(flowText(item));
  entered.materials = scene.materials;
  for (Material& material : entered.materials) material.texture.reset();
  entered.modelled = method.modelled();
  ontology_ = scene.ontology;
}

void Recorder::writeHits(const Shot& shot, const Hits& hits) {
  const std::filesystem::path file = writer_->file(shot.sample, shot.sensorName, "hits.exr");
  {
    const StageTimer timer(clock_, "write_hits");
    scanmill::writeHits(file, hits);
  }
  writer_->add({shot.sample, shot.sensorName, shot.time, shot.worldFromSensor, file.filename().string(), {}});
}

RecordedShot Recorder::beginPasses(const Shot& shot) {
  return {shot.sample, shot.sensorName, shot.time, shot.worldFromSensor, "", {}};
}

void Recorder::writeStep(const PassStep& step, RecordedShot& record) {
  RecordedStep written{step.firstColumn, step.endColumn, step.worldFromRig, {}};
  for (const PassImage& image : step.images) {
    const auto file =
        writer_->file(record.sample, record.sensor, fmt::format("{}.{}.exr", record.steps.size(), image.camera.name));
    written.images.push_back(file.filename().string());
  }
  {
    const StageTimer timer(clock_, "write_passes");
    parallelFor(step.images.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        scanmill::writePasses(writer_->folder() / written.images[i], step.images[i]);
      }
    });
  }
  record.steps.push_back(std::move(written));
}

void Recorder::writePasses(const RecordedShot& record) {
  writer_->add(record);
}

Recording Recorder::describe() const {
  Recording recording;
  recording.kind = kind_;
  recording.programVersion = kVersion;
  recording.method = plan_.pipeline.methodName();
  recording.ontology = ontology_;
  for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
    const MountedSensor& sensor = plan_.pipeline.sensors[s];
    const BeamTable& beams = *plan_.sensors[s].beams;
    recording.sensors.push_back({sensor.name, beams.rings, beams.columns, beamsHash(beams), sensor.vehicleFromSensor});
  }
  std::vector<const Sequence*> scenes;  // the first sequence of each scene
  for (const auto& [index, entered] : entered_) {
    const Sequence& sequence = plan_.pipeline.sequences[index];
    const auto scene = std::ranges::find_if(scenes, [&](const Sequence* first) { return sequence.sameScene(*first); });
    recording.sequences.push_back(entered.record);
    recording.sequences.back().materials = static_cast<std::uint32_t>(scene - scenes.begin());
    if (scene == scenes.end()) {
      scenes.push_back(&sequence);
      recording.materials.push_back(entered.materials);
    }
    addItems(entered.modelled, recording.modelled);
  }
  return recording;
}

void Recorder::finish() {
  if (writer_) writer_->finish(describe());
}

}  // namespace scanmill
