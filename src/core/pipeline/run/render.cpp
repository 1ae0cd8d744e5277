#include "pipeline/run/render.h"

#include <memory>
#include <utility>

#include "base/append_new.h"
#include "base/error.h"
#include "base/stage_clock.h"
#include "methods/depth_camera/depth_camera.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/recorder.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

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
        RecordedShot record = Recorder::beginPasses(shot);
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
