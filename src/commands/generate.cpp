#include "pipeline/run/generate.h"

#include <fmt/core.h>

#include <utility>

#include "base/grouped.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "base/short_text.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "commands/table.h"
#include "config/version.h"
#include "dataset/dataset_folder.h"
#include "dataset/shard_name.h"
#include "evaluate/auto/calibrate.h"
#include "pipeline/run/recorder.h"

namespace scanmill {

namespace {

void printMade(const GenerateSummary& s, const std::string& folder) {
  const std::size_t warned = warningCount();
  fmt::print("{} samples in {} shards{}, {}, in {}{}\n", s.manifest.samples.size(), s.manifest.shards.size(),
             s.resumedShards == 0 ? std::string() : fmt::format(" ({} of them were there)", s.resumedShards),
             shortBytes(static_cast<double>(s.bytes)), folder,
             warned == 0 ? std::string() : fmt::format("; {} warning{}", warned, warned == 1 ? "" : "s"));
}

void printSummary(const GenerateSummary& s, const std::string& folder) {
  std::vector<std::vector<std::string>> rows{{"class", "points", "share"}};
  for (const auto& [id, count] : s.pointsPerClass) {
    const SemanticClass* c = s.manifest.ontology.find(id);
    rows.push_back({c == nullptr ? std::to_string(id) : c->name, grouped(count),
                    percent(static_cast<double>(count), static_cast<double>(s.points))});
  }
  fmt::print("{}\n", formatTable(rows));
  printMade(s, folder);
  fmt::print("{} beams gave {} points in {}: {} beams/s, {:.2f} bytes a point\n", grouped(s.beams), grouped(s.points),
             shortTime(s.seconds), shortNumber(static_cast<double>(s.beams) / s.seconds),
             s.points == 0 ? 0.0 : static_cast<double>(s.bytes) / static_cast<double>(s.points));
  fmt::print("stages (s of thread time):");
  for (const auto& [name, seconds] : s.stages) fmt::print(" {} {:.2f}", name, seconds);
  fmt::print("\nnext: scanmill view {0}; scanmill report {0}; scanmill verify {0}\n", folder);
}

// `method: auto` becomes the setting that is the cheapest here.
void chooseMethod(Plan& plan, const GenerateOptions& options) {
  checkAutoChoice(plan.pipeline());
  // Refused now, not after minutes.
  if (options.resume) {
    throw InputError(
        "--resume needs a method that does not change: `method: auto` measures anew; name the one that it "
        "took");
  }
  DatasetFolder::check(options.folder, options.overwrite ? FolderUse::Replace : FolderUse::New);
  const Calibration calibration = calibrate(plan, options.quiet, options.stop);
  const CalibratedSetting& chosen = calibration.settings[calibration.chosen];
  if (!options.quiet) {
    fmt::print("method: auto takes {}: {}\n", chosen.setting.setting.name, calibration.why);
    fmt::print("the same again: --set '{}'\n\n", chosen.setting.setting.assignment());
  }
  plan.choose(chosen.setting.choice, calibration.record());
}

// So that scripts can always say --resume.
bool isWholeAlready(const Plan& plan, const std::filesystem::path& folder) {
  if (DatasetFolder::isUnfinished(folder) || !std::filesystem::exists(folder / kManifestName)) return false;
  const Manifest made = readManifest(folder);
  return made.programVersion == kVersion && made.pipelineSha256 == sha256(plan.pipeline().text);
}

}  // namespace

int runGenerate(const std::vector<std::string>& arguments) {
  const Command& command = commandNamed("generate");
  cxxopts::Options options = describe(command);
  options.add_options()("o,out", "folder of the dataset (made where absent)", cxxopts::value<std::string>(), "DIR")(
      "overwrite", "replace a dataset, or recordings, that are there already")(
      "resume", "go on with a dataset that was interrupted: the bytes are those of one that was not")(
      "keep-hits", "keep what the beams meet, to make scans again without tracing", cxxopts::value<std::string>(),
      "DIR")("keep-passes", "keep the images that the method depth_camera draws", cxxopts::value<std::string>(), "DIR");
  addRecordingOptions(options);
  options.add_options()("q,quiet", "one line in place of progress and tables");
  addPipelineOptions(options);
  const Arguments parsed = parseArguments(command, options, arguments,
                                          "  scanmill generate pipelines/quickstart.yaml -o out/quickstart\n"
                                          "  scanmill generate pipelines/quickstart.yaml -o out/b --seed 7 "
                                          "--set 'scenes.0.seeds=[4,5]' --set splits=null\n"
                                          "  scanmill generate pipelines/quickstart.yaml -o out/night --resume\n"
                                          "  scanmill generate pipelines/street.yaml -o out/c --keep-hits out/hits\n"
                                          "  scanmill generate pipelines/street.yaml -o out/d --from-hits out/hits "
                                          "--set 'effects=[intensity]'\n");
  if (parsed.help) return 0;
  const std::string file = parsed.positional("PIPELINE");
  if (parsed.options.count("out") == 0 || parsed.options["out"].as<std::string>().empty())
    throw InputError("-o DIR is missing: where should the dataset go?");
  const ThreadLimit limit(threadOption(parsed));
  GenerateOptions generateOptions;
  generateOptions.keepHits = folderOption(parsed, "keep-hits");
  generateOptions.keepPasses = folderOption(parsed, "keep-passes");
  const bool keeps = !generateOptions.keepHits.empty() || !generateOptions.keepPasses.empty();
  Plan plan(readPipeline(file, pipelineOverrides(parsed), recordingOf(parsed)),
            keeps ? recordedChannels() : Channels{});
  generateOptions.folder = parsed.options["out"].as<std::string>();
  generateOptions.overwrite = parsed.options.count("overwrite") > 0;
  generateOptions.resume = parsed.options.count("resume") > 0;
  if (generateOptions.resume && generateOptions.overwrite) {
    throw InputError("--resume goes on with what is there, --overwrite begins anew: give one of them");
  }
  generateOptions.quiet = parsed.options.count("quiet") > 0;
  generateOptions.stop = &stopSignal();
  if (!generateOptions.keepPasses.empty()) plan.requirePasses();
  if (!generateOptions.keepHits.empty()) plan.requireOneRay();
  if (plan.pipeline().method.automatic) chooseMethod(plan, generateOptions);
  if (generateOptions.resume && isWholeAlready(plan, generateOptions.folder)) {
    fmt::print("{}: is whole, there is nothing to resume\n", generateOptions.folder.string());
    return 0;
  }
  const GenerateSummary summary = generate(plan, generateOptions);
  for (const std::string& warning : summary.warnings) warn(warning);
  if (generateOptions.quiet) {
    printMade(summary, generateOptions.folder.string());
  } else {
    printSummary(summary, generateOptions.folder.string());
  }
  return 0;
}

}  // namespace scanmill
