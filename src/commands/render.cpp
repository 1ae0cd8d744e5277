#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "pipeline/run/recorder.h"

namespace scanmill {

namespace {

// Returns "depth" for the range, which images store along the camera's axis; otherwise the channel's name.
std::string_view passName(const ChannelRow& row) {
  return row.channel == Channel::Range ? "depth" : row.name;
}

// Reads --passes: "all", or names with commas between them.
PassChoice readPassList(const std::string& list) {
  PassChoice choice;
  if (list == "all") {
    choice.channels = channelsThat(&ChannelRow::rendered);
    choice.surfaceParameters = true;
    return choice;
  }
  std::vector<std::string> names{"all", "look"};
  for (const ChannelRow& row : kChannels) {
    if (row.rendered) names.emplace_back(passName(row));
  }
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t comma = std::min(list.find(',', begin), list.size());
    const std::string name = list.substr(begin, comma - begin);
    const auto isNamed = [&](const ChannelRow& row) { return row.rendered && name == passName(row); };
    const auto row = std::ranges::find_if(kChannels, isNamed);
    if (name == "look") {
      choice.surfaceParameters = true;
    } else if (row != std::end(kChannels)) {
      choice.channels |= row->channel;
    } else {
      throw InputError(fmt::format("--passes: unknown pass '{}'{}", name, suggestion(name, names)));
    }
    begin = comma + 1;
  }
  return choice;
}

}  // namespace

int runRender(const std::vector<std::string>& arguments) {
  CommandOptions options("render");
  options.add("o,out", "folder of the recording; it is made if it does not exist", textValue(), "DIR");
  options.add("passes",
              "the images to write: all, or a list with commas of depth, normal, instance, semantic, "
              "material, primitive, reflectance, and look (roughness, metallic and retroreflectance)",
              textValue()->default_value("all"), "LIST");
  options.add("overwrite", "replace an existing recording");
  options.add("q,quiet", "print one line instead of progress and tables");
  addPipelineOptions(options);
  const Arguments parsed = parseArguments(
      options, arguments,
      "  scanmill render pipelines/street.yaml -o out/passes --set method=depth_camera\n"
      "  scanmill render pipelines/street.yaml -o out/depth --set method=depth_camera --passes depth,semantic\n"
      "  scanmill generate pipelines/street.yaml -o out/a --from-passes out/passes\n");
  const std::string file = parsed.positional("PIPELINE");
  RenderOptions render;
  render.folder = parsed.text("out");
  if (render.folder.empty()) throw InputError("-o DIR is missing: where should the passes go?");
  render.passes = readPassList(parsed.options["passes"].as<std::string>());
  const Plan plan = makePlan(readPipeline(parsed.pipeline(), pipelineOverrides(parsed)), render.passes.channels);
  render.overwrite = parsed.has("overwrite");
  render.quiet = parsed.has("quiet");
  render.stop = &stopSignal();
  const RenderSummary summary = scanmill::render(plan, render);
  for (const std::string& line : summary.warnings) warn(line);
  printText("{} images of {} shots, {}, in {}\n", grouped(summary.images), grouped(summary.shots),
            shortBytes(summary.bytes), render.folder.string());
  if (render.quiet) return 0;
  printText("stages (s):");
  for (const auto& [name, seconds] : summary.stages) printText(" {} {:.2f}", name, seconds);
  printText("\nnext: scanmill generate {} -o DIR --from-passes {}\n", file, render.folder.string());
  return 0;
}

}  // namespace scanmill
