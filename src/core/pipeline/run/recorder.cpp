#include "pipeline/run/recorder.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "base/append_new.h"
#include "base/error.h"
#include "base/parallel.h"
#include "config/value.h"
#include "config/version.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "pipeline/run/progress.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {
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

void Recorder::writeStep(const PassStep& step, RecordedShot& record) {
  RecordedStep written{step.firstColumn, step.endColumn, step.worldFromRig, {}};
  for (const PassImage& image : step.images) {
    const auto file =
        writer_->file(record.sample, record.sensor, fmt::format("{}.{}.exr", record.steps.size(), image.camera.name));
    written.images.push_back(file.filename().string());
  }
  {
    const StageTimer timer(clock_, "write_passes");
    parallelForEach(step.images.size(), 1, [&](std::size_t i) {
      scanmill::writePasses(writer_->folder() / written.images[i], step.images[i]);
    });
  }
  record.steps.push_back(std::move(written));
}

void Recorder::finish() {
  if (!records()) return;
  Recording recording{
      .kind = kind_, .programVersion = kVersion, .method = plan_.pipeline.methodName(), .ontology = ontology_};
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
  writer_->finish(recording);
}

RenderSummary render(const Plan& plan, const RenderOptions& options) {
  plan.requirePasses();
  const Pipeline& pipeline = plan.pipeline;
  ShotSource source(plan);
  RenderSummary summary;
  StageClock clock({"setup"});
  TraceAccount account;  // times and warnings of the method in the current scene
  Recorder recorder(plan, RecordingKind::Passes);
  bool isOpen = false;  // the recorder is opened after the first scene is set up, since it may remove an old recording
  std::unique_ptr<Scene> scene;
  std::unique_ptr<Method> method;
  Progress progress("render", pipeline.frames(), "frames", "pixels", options.quiet);
  for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
    const Sequence& sequence = pipeline.sequences[s];
    if (s == 0 || !sequence.sameScene(pipeline.sequences[s - 1])) {
      const StageTimer timer(clock, "setup");
      addSeconds(account.seconds, summary.stages);
      account = {};
      method.reset();
      scene = std::make_unique<Scene>(source.load(s));
      method = source.method(*scene);
      for (const Shot& shot : source.frame(s, 0).shots) account += method->prepare(shot);
    }
    if (!std::exchange(isOpen, true)) recorder.open(options.folder, options.overwrite);
    recorder.enter(s, *scene, *method);
    for (std::uint32_t frame = 0; frame < sequence.frames; ++frame) {
      if (options.stop != nullptr && *options.stop) {
        throw Error("stopped: the recording is unfinished, so the folder has no recording.json");
      }
      double pixels = 0;
      for (const Shot& shot : source.frame(s, frame).shots) {
        RecordedShot record{shot.sample, shot.sensorName, shot.time, shot.worldFromSensor, "", {}};
        account += method->depthCamera()->draw(shot, options.passes, [&](PassStep&& step) {
          for (const PassImage& image : step.images) pixels += static_cast<double>(image.camera.pixels());
          summary.images += step.images.size();
          recorder.writeStep(step, record);
        });
        recorder.writePasses(record);
        ++summary.shots;
      }
      progress.advance(1, pixels);
    }
    appendNew(account.warningTexts(), summary.warnings);
  }
  for (const StageSeconds& seconds : {account.seconds, clock.seconds(), recorder.stageSeconds()}) {
    addSeconds(seconds, summary.stages);
  }
  recorder.finish();
  for (const auto& entry : std::filesystem::directory_iterator(options.folder)) summary.bytes += entry.file_size();
  summary.seconds = progress.seconds();
  return summary;
}

}  // namespace scanmill
