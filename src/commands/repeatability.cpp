#include "study/repeatability/repeatability.h"

#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "pipeline/plan/plan.h"
#include "pipeline/scenes/shot_source.h"
#include "report/page/page.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr const char* kRepeatabilityFile = "repeatability.json";

}  // namespace

int runRepeatability(const std::vector<std::string>& arguments) {
  CommandOptions options("repeatability");
  options.add("o,out", "folder of the figures; it is made if it does not exist", textValue(), "DIR");
  options.add("overwrite", "replace existing figures");
  options.add("q,quiet", "print one line instead of progress");
  addPipelineOptions(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill repeatability pipelines/paper/repeatability.yaml -o out/repeatability\n"
                     "  scanmill repeatability pipelines/paper/repeatability.yaml -o out/methods "
                     "--set 'repeatability.methods=[ray_tracing, {depth_camera: {resolution: 512}}]'\n"
                     "  scanmill repeatability pipelines/street.yaml -o out/nearest --set trajectories.0.frames=3\n");
  parsed.positional("PIPELINE");  // report a missing pipeline before all else
  const std::filesystem::path folder = folderOption(parsed, "out");
  if (folder.empty()) throw InputError("-o DIR is missing: where should the figures go?");
  Pipeline pipeline = readPipeline(parsed.pipeline(), pipelineOverrides(parsed));
  const Channels channels = repeatabilityChannels(pipeline);
  const Plan plan = makePlan(std::move(pipeline), channels);
  const ShotSource vehicle(plan);  // a vehicle that cannot be used is refused before the folder is made
  prepareReportFolder(folder, kRepeatabilityFile, parsed.has("overwrite"));
  const RepeatabilityOptions run{.quiet = parsed.has("quiet"), .stop = &stopSignal()};
  const Repeatability result = measureRepeatability(plan, run);
  writeFile(folder / kRepeatabilityFile, repeatabilityJson(result));
  for (const std::string& warning : result.warnings) warn(warning);
  std::size_t poses = 0;
  for (const RepeatedView& view : result.views) poses += view.poses.size();
  printText("{}, {}: {}; scripts/repeatability_charts draws them\n", pluralOf(poses, "pose"),
            pluralOf(result.levels.size(), "noise level"), (folder / kRepeatabilityFile).string());
  return 0;
}

}  // namespace scanmill
