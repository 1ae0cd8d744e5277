#include "pipeline/run/generate.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/forecast_text.h"
#include "commands/stop_signal.h"
#include "commands/table.h"
#include "dataset/dataset_folder.h"
#include "dataset/names.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/recorder.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

// Least number of rays for which the time is forecast: a forecast takes almost a second, longer than making a smaller
// dataset.
constexpr double kRaysWorthAForecast = 1e7;

// Returns what is in the folder, such as "2 shards (1 of them existed already), 3.0 MiB, in out/street; 1 warning".
// `shards`: number of all shards in the folder.
std::string shardsText(std::uint64_t shards, const GenerateSummary& s, const std::filesystem::path& folder) {
  const std::string resumed =
      s.resumedShards == 0 ? std::string() : fmt::format(" ({} of them existed already)", s.resumedShards);
  const std::string warnings = warningCount() == 0 ? std::string() : "; " + pluralOf(warningCount(), "warning");
  return fmt::format("{}{}, {}, in {}{}", pluralOf(shards, "shard"), resumed, shortBytes(s.bytes), folder.string(),
                     warnings);
}

// Prints one line: what the dataset consists of or, if it is not complete yet, which command completes it.
void printContents(const GenerateSummary& s, const GenerateOptions& options) {
  if (s.complete) {
    printText("{} in {}\n", pluralOf(s.manifest.samples.size(), "sample"),
              shardsText(s.manifest.shards.size(), s, options.folder));
    return;
  }
  printText("{}; {} scanmill merge {}\n", shardsText(s.shards + s.resumedShards, s, options.folder),
            options.shards.kind == ShardChoice::Kind::Any ? "another process completes the dataset, or"
                                                          : "when all shards exist:",
            options.folder.string());
}

void printPointsPerClass(const GenerateSummary& s) {
  Rows rows{{"class", "points", "share"}};
  for (const auto& [id, count] : s.pointsPerClass) {
    const SemanticClass* c = s.manifest.ontology.find(id);
    rows.push_back({c == nullptr ? std::to_string(id) : c->name, grouped(count), percent(count, s.points)});
  }
  printText("{}\n", formatTable(rows));
}

// Prints the speed of the run, the forecast (if there is one) beside the actual time and size, and each stage's time.
void printCosts(const GenerateSummary& s, const std::optional<Forecast>& predicted) {
  // Other processes may have made some of the counted samples; the speed counts only this process.
  const double shareMadeHere =
      static_cast<double>(s.samplesMade) / static_cast<double>(std::max<std::size_t>(s.samples, 1));
  printText("{} beams gave {} points in {}: {} beams/s, {:.2f} bytes per point\n", grouped(s.beams), grouped(s.points),
            shortTime(s.seconds), shortNumber(static_cast<double>(s.beams) * shareMadeHere / s.seconds),
            s.points == 0 ? 0.0 : static_cast<double>(s.bytes) / static_cast<double>(s.points));
  if (predicted) {
    printText("forecast: {}; {}; actual: {} and {}\n", timeText(*predicted), sizeText(*predicted), shortTime(s.seconds),
              shortBytes(s.bytes));
  }
  printText("processor time {:.2f} s, by stage{}:", s.processorSeconds,
            s.stages.contains("render") ? " (upload, render and read_back: s of the clock)" : "");
  for (const auto& [name, seconds] : s.stages) printText(" {} {:.2f}", name, seconds);
  printText("\n");
}

// Chooses the shards of one of several processes: every `workers`-th shard, starting with the shard `worker` (from 0).
ShardChoice shardsOfWorker(std::uint64_t worker, std::uint64_t workers, std::uint64_t shards) {
  if (workers == 0) throw InputError("--workers 0: give at least 1");
  if (worker >= workers) {
    throw InputError(fmt::format("--worker {} of {}: workers are numbered from 0", worker, workers));
  }
  ShardChoice choice{ShardChoice::Kind::Listed, {}};
  for (std::uint64_t shard = worker; shard < shards; shard += workers) choice.listed.push_back(shard);
  if (choice.listed.empty()) {
    warn("worker {} of {} has no shard to make: the dataset has {}; a smaller `output.shard_samples` gives more",
         worker, workers, pluralOf(shards, "shard"));
  }
  return choice;
}

// Reads --shards, --worker and --workers; without them, chooses all shards. `shards`: number of the dataset's shards.
ShardChoice shardsOption(const Arguments& parsed, std::uint64_t shards) {
  const bool hasShards = parsed.has("shards");
  const bool hasWorker = parsed.has("worker");
  const bool hasWorkers = parsed.has("workers");
  if (!hasShards && !hasWorker && !hasWorkers) return {};
  if (hasShards && (hasWorker || hasWorkers)) {
    throw InputError(
        "--shards names the shards to make, --workers shares them among processes: give only one of the two");
  }
  if (hasShards) return {ShardChoice::Kind::Listed, parseShardRanges(parsed.text("shards"), shards)};
  if (parsed.text("workers") == "auto") {
    if (hasWorker) throw InputError("--workers auto needs no --worker: leave it out");
    return {ShardChoice::Kind::Any, {}};
  }
  if (!hasWorker || !hasWorkers) {
    throw InputError("give both --worker I and --workers N, with I from 0 to N - 1, or --workers auto");
  }
  return shardsOfWorker(countOption(parsed, "worker"), countOption(parsed, "workers"), shards);
}

// Reads all options of GenerateOptions except the choice of shards, which shardsOption() reads.
GenerateOptions folderOptions(const Arguments& parsed, const std::filesystem::path& folder) {
  GenerateOptions options{.folder = folder,
                          .keepHits = folderOption(parsed, "keep-hits"),
                          .overwrite = parsed.has("overwrite"),
                          .resume = parsed.has("resume")};
  const std::string resume = parsed.text("resume");
  if (!resume.empty() && resume != "anyway") {
    throw InputError(fmt::format(
        "--resume={}: write --resume, or --resume=anyway to keep shards although files of their scenes have changed",
        resume));
  }
  options.anyFiles = resume == "anyway";
  if (options.resume && options.overwrite) {
    throw InputError("--resume continues a dataset, --overwrite replaces it: give only one of the two");
  }
  options.quiet = parsed.has("quiet");
  options.stop = &stopSignal();
  return options;
}

// Measures the cost of samples, then prints and returns a forecast of the dataset's time and size. Returns nothing if
// the cost cannot be measured.
std::optional<Forecast> printForecastOf(const Arguments& parsed, const Plan& plan) {
  std::optional<SampleCosts> costs;
  try {
    costs = sampleCosts(parsed, plan);
  } catch (const Error&) {
    return std::nullopt;
  }
  const Forecast predicted = forecast(*costs, plan.pipeline.frames(), scenesOf(plan.pipeline));
  printText("this takes about {} and {}\n", timeText(predicted), sizeText(predicted));
  return predicted;
}

void makeDataset(const Arguments& parsed, const std::filesystem::path& folder) {
  GenerateOptions options = folderOptions(parsed, folder);
  const Plan plan = makePlan(readPipeline(parsed.pipeline(), pipelineOverrides(parsed), recordingOf(parsed)),
                             parsed.has("keep-hits") ? channelsThat(&ChannelRow::recorded) : Channels{});
  const std::vector<ShardJob> jobs = shardJobs(plan);
  options.shards = shardsOption(parsed, jobs.size());
  const bool allShards = options.shards.kind == ShardChoice::Kind::All;
  if (options.overwrite && !allShards) {
    throw InputError(
        "--overwrite would remove the shards of other processes: remove the old dataset by hand, and leave --overwrite "
        "out");
  }
  if (!options.keepHits.empty()) plan.requireOneRay();
  // A complete dataset is not an error, so that scripts can always pass --resume.
  const auto complete = options.resume ? wholeDatasetOf(datasetPlan(plan, jobs), folder) : std::nullopt;
  if (complete) {
    if (!options.anyFiles) requireUnchangedFiles(complete->files, plan.pipeline.file.parent_path(), folder);
    printText("{}: is complete: there is nothing to resume\n", folder.string());
    return;
  }
  DatasetFolder::check(folder, options.use());  // before the forecast, which takes a second
  const bool forecasts = plan.pipeline.rays() >= kRaysWorthAForecast && !options.quiet && !options.resume && allShards;
  const std::optional<Forecast> predicted = forecasts ? printForecastOf(parsed, plan) : std::nullopt;
  const GenerateSummary summary = generate(plan, options);
  if (summary.complete && summary.shards == 0 && summary.resumedShards == 0) {
    printText("{}: is complete: there is nothing to make\n", folder.string());
    return;
  }
  for (const std::string& warning : summary.warnings) warn(warning);
  if (options.quiet) return printContents(summary, options);
  printPointsPerClass(summary);
  printContents(summary, options);
  printCosts(summary, predicted);
  if (summary.complete)
    printText("next: scanmill view {0}; scanmill report {0}; scanmill verify {0}\n", folder.string());
}

void addGenerateOptions(CommandOptions& options) {
  options.add("o,out", "folder of the dataset; it is made if it does not exist", textValue(), "DIR");
  options.add("overwrite", "replace an existing dataset or recording");
  options.add(
      "resume",
      "continue an interrupted dataset; the bytes are the same as without the interruption. A file of a scene that has "
      "changed since is refused by name; --resume=anyway keeps the shards made before",
      textValue()->implicit_value(""), "anyway");
  options.add("shards", "make only these shards, such as 0-9,12; `scanmill merge` completes the dataset", textValue(),
              "RANGES");
  options.add("worker", "make every N-th shard, starting with shard I (from 0), as one of N processes", textValue(),
              "I");
  options.add(
      "workers",
      "the number N of processes for --worker; or auto: the processes share the shards by themselves, and the last one "
      "completes the dataset",
      textValue(), "N|auto");
  options.add("keep-hits", "save what the beams hit, so that scans can be made again without tracing", textValue(),
              "DIR");
  addRecordingOptions(options);
  options.add("q,quiet", "print one line instead of progress and tables");
  addPipelineOptions(options);
}

}  // namespace

int runGenerate(const std::vector<std::string>& arguments) {
  CommandOptions options("generate");
  addGenerateOptions(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill generate pipelines/quickstart.yaml -o out/quickstart\n"
                     "  scanmill generate pipelines/quickstart.yaml -o out/b --seed 7 "
                     "--set 'scenes.0.seeds=[4,5]' --set splits=null\n"
                     "  scanmill generate pipelines/quickstart.yaml -o out/night --resume\n"
                     "  scanmill generate pipelines/street.yaml -o out/big --workers auto"
                     "    # on as many machines as share the folder\n"
                     "  scanmill generate pipelines/street.yaml -o out/c --keep-hits out/hits\n"
                     "  scanmill generate pipelines/street.yaml -o out/d --from-hits out/hits "
                     "--set 'effects=[intensity]'\n"
                     "  scanmill generate quickstart -o out/fog --set 'corruption={fog: heavy}'\n");
  parsed.positional("PIPELINE");  // report a missing pipeline before all else
  const std::filesystem::path folder = parsed.text("out");
  if (folder.empty()) throw InputError("-o DIR is missing: where should the dataset go?");
  makeDataset(parsed, folder);
  return 0;
}

}  // namespace scanmill
