#include "exports/export.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <optional>

#include "assets/worlds/world_asset.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "config/fields.h"
#include "config/resources.h"
#include "dataset/folder_contents.h"
#include "pipeline/run/progress.h"

namespace scanmill {

namespace {

std::string layoutLines() {
  std::string lines;
  for (const LayoutEntry& entry : layouts()) lines += fmt::format("  {:15} {}\n", entry.name, entry.summary);
  return lines;
}

}  // namespace

int runExport(const std::vector<std::string>& arguments) {
  CommandOptions options("export");
  options.add("to", fmt::format("{}", fmt::join(namesOf(layouts()), ", ")), textValue(), "LAYOUT");
  options.add("o,out", "folder to write", textValue(), "DIR");
  options.add(
      "classes",
      "ontology to write, instead of the layout's: a file, or a name of `scanmill list ontologies`; its aliases map "
      "the dataset's classes to its own",
      textValue(), "NAME");
  options.add("sensor", "only this one; may be given again", listValue(), "NAME");
  options.add("split", "only this one; may be given again", listValue(), "NAME");
  options.add("frames", "names of the world's and the vehicle's frame in MCAP files (default: map,base_link)",
              textValue(), "WORLD,VEHICLE");
  options.add("robot", "the vehicle's URDF file, for /robot_description in MCAP files", textValue(), "FILE");
  options.add("overwrite", "replace an existing export, complete or not: its folder is emptied");
  options.add("q,quiet", "print no progress");
  addThreads(options);
  const Arguments parsed = parseArguments(
      options, arguments,
      "  scanmill export out/quickstart --to semantic_kitti -o out/quickstart_kitti\n"
      "  scanmill export out/quickstart --to mcap --split val -o out/quickstart_val   # Foxglove, ROS 2\n\nlayouts:\n" +
          layoutLines());
  ExportOptions exportOptions;
  exportOptions.dataset = parsed.positional("DIR");
  requireDataset(exportOptions.dataset);
  if (!parsed.has("to")) throw InputError("--to LAYOUT is missing; the layouts are:\n" + layoutLines());
  exportOptions.layout = &requireLayout(parsed.text("to"));
  exportOptions.folder = folderOption(parsed, "out");
  if (exportOptions.folder.empty()) throw InputError("-o DIR is missing: name the folder to write");
  if (parsed.has("classes")) exportOptions.classes = namedResource(parsed.text("classes"), "labels");
  exportOptions.sensors = parsed.list("sensor");
  exportOptions.splits = parsed.list("split");
  for (const char* option : {"frames", "robot"}) {
    if (!parsed.has(option) || exportOptions.layout->name == "mcap") continue;
    throw InputError(fmt::format("--{} is only for --to mcap", option));
  }
  if (parsed.has("frames")) {
    const std::string frames = parsed.text("frames");
    const std::size_t comma = frames.find(',');
    exportOptions.ros.world = frames.substr(0, comma);
    exportOptions.ros.vehicle = comma == std::string::npos ? "" : frames.substr(comma + 1);
    if (exportOptions.ros.world.empty() || exportOptions.ros.vehicle.empty()) {
      throw InputError(fmt::format("--frames must be two names such as odom,base_link, not '{}'", frames));
    }
  }
  exportOptions.ros.robot = parsed.text("robot");
  if (parsed.has("robot")) exportOptions.ros.links = readLinkNames(exportOptions.ros.robot);
  exportOptions.overwrite = parsed.has("overwrite");
  exportOptions.stop = &stopSignal();
  std::optional<Progress> progress;  // progress bar of the current stage
  std::string currentStage;
  std::uint64_t shownFrames = 0;
  const bool quiet = parsed.has("quiet");
  exportOptions.progress = [&](const char* stage, std::uint64_t doneFrames, std::uint64_t allFrames) {
    if (currentStage != stage) {
      currentStage = stage;
      shownFrames = 0;
      progress.reset();  // ends the progress bar of the stage before
      progress.emplace(stage, allFrames, "frames", "frames", quiet);
    }
    progress->advance(doneFrames - shownFrames, static_cast<double>(doneFrames - shownFrames));
    shownFrames = doneFrames;
  };
  const ExportSummary summary = exportDataset(exportOptions);
  progress.reset();
  for (const std::string& warning : summary.warnings) warn(warning);
  printText("wrote {} of {} to {}\n", pluralOf(summary.frames, "frame"), pluralOf(summary.sequences, "sequence"),
            exportOptions.folder.string());
  return 0;
}

}  // namespace scanmill
