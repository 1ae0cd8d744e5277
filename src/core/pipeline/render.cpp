#include "pipeline/render.h"

#include <chrono>
#include <memory>

#include "base/error.h"
#include "pipeline/keeper.h"
#include "pipeline/progress.h"

namespace scanmill {

namespace {

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

RenderSummary render(const Plan& plan, const RenderOptions& options) {
  if (plan.pipeline().method.automatic) {
    throw InputError(plan.pipeline().method.options.where,
                     "method auto may choose one that draws no passes: take `method: depth_camera`");
  }
  const Pipeline& pipeline = plan.pipeline();
  RenderSummary summary;
  Keeper keeper(plan);
  bool open = false;
  std::unique_ptr<Scene> scene;
  std::unique_ptr<Method> method;
  Progress progress("render", pipeline.frames(), "frames", "pixels", options.quiet);
  const auto addStages = [&] {
    for (const auto& [stage, seconds] : method->stageSeconds()) summary.stages[stage] += seconds;
  };
  for (std::size_t s = 0; s < pipeline.sequences.size(); ++s) {
    const Sequence& sequence = pipeline.sequences[s];
    if (s == 0 || !sequence.sameScene(pipeline.sequences[s - 1])) {
      const auto start = std::chrono::steady_clock::now();
      if (method != nullptr) addStages();
      keeper.leave();
      method.reset();
      scene = std::make_unique<Scene>(plan.loadScene(sequence));
      method = plan.makeMethod(*scene);
      for (const Shot& shot : plan.shots(s, 0)) method->prepare(shot);
      summary.stages["setup"] += secondsSince(start);
    }
    if (!open) keeper.open({}, options.folder, options.overwrite);
    open = true;
    keeper.enter(s, *scene, *method);
    for (std::uint32_t frame = 0; frame < sequence.frames; ++frame) {
      if (options.stop != nullptr && *options.stop) {
        throw Error("stopped: the folder holds no recording.json, hence no finished recording");
      }
      double pixels = 0;
      for (const Shot& shot : plan.shots(s, frame)) {
        keeper.keepPasses(shot, options.passes, [&](const PassStep& step) {
          for (const PassImage& image : step.images) pixels += static_cast<double>(image.camera.pixels());
          summary.images += step.images.size();
        });
        ++summary.shots;
      }
      progress.advance(1, pixels);
    }
    for (std::string& line : method->warnings()) summary.warnings.push_back(std::move(line));
  }
  if (method != nullptr) addStages();
  for (const auto& [stage, seconds] : keeper.stageSeconds()) summary.stages[stage] = seconds;
  keeper.finish();
  for (const auto& entry : std::filesystem::directory_iterator(options.folder)) summary.bytes += entry.file_size();
  summary.seconds = progress.seconds();
  return summary;
}

}  // namespace scanmill
