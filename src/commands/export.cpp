#include "exports/export.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <optional>

#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
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
  std::vector<std::string> names;
  for (const LayoutEntry& entry : layouts()) names.emplace_back(entry.name);
  cxxopts::OptionAdder add = options.add_options();
  add("to", fmt::format("{}", fmt::join(names, ", ")), textValue(), "LAYOUT");
  add("o,out", "folder to write", textValue(), "DIR");
  add("classes",
      "ontology to write, instead of the layout's: a file, or a name of `scanmill list ontologies`; its aliases map "
      "the dataset's classes to its own",
      textValue(), "NAME");
  add("sensor", "only this one; may be given again", listValue(), "NAME");
  add("split", "only this one; may be given again", listValue(), "NAME");
  add("overwrite", "replace an existing export, complete or not: its folder is emptied");
  add("q,quiet", "print no progress");
  add("threads", "how many threads to use, 0 for all cores", cxxopts::value<int>()->default_value("0"), "N");
  const Arguments parsed = parseArguments(
      options, arguments,
      "  scanmill export out/quickstart --to semantic_kitti -o out/quickstart_kitti\n"
      "  scanmill export out/quickstart --to mcap --split val -o out/quickstart_val   # Foxglove, ROS 2\n\nlayouts:\n" +
          layoutLines());
  if (parsed.help) return 0;
  ExportOptions chosen;
  chosen.dataset = parsed.positional("DIR");
  requireDataset(chosen.dataset);
  if (!parsed.has("to")) throw InputError("--to LAYOUT is missing; the layouts are:\n" + layoutLines());
  chosen.layout = &requireLayout(parsed.text("to"));
  chosen.folder = folderOption(parsed, "out");
  if (chosen.folder.empty()) throw InputError("-o DIR is missing: name the folder to write");
  if (parsed.has("classes")) {
    chosen.classes = namedResource(parsed.text("classes"), "labels");
  }
  chosen.sensors = parsed.list("sensor");
  chosen.splits = parsed.list("split");
  chosen.overwrite = parsed.has("overwrite");
  chosen.stop = &stopSignal();
  const ResourceLimits limits(parsed);
  std::optional<Progress> progress;
  std::string stage;
  std::uint64_t before = 0;
  const bool quiet = parsed.has("quiet");
  chosen.progress = [&](const char* doing, std::uint64_t done, std::uint64_t all) {
    if (stage != doing) {
      stage = doing;
      before = 0;
      progress.reset();
      progress.emplace(stage, all, "frames", "frames", quiet);
    }
    progress->advance(done - before, static_cast<double>(done - before));
    before = done;
  };
  const ExportSummary summary = exportDataset(chosen);
  progress.reset();
  for (const std::string& warning : summary.warnings) warn(warning);
  printText("wrote {} of {} to {}\n", pluralOf(summary.frames, "frame"), pluralOf(summary.sequences, "sequence"),
            chosen.folder.string());
  return 0;
}

}  // namespace scanmill
