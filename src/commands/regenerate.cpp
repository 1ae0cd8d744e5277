#include "pipeline/run/regenerate.h"

#include <fmt/format.h>

#include "base/parallel.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "dataset/shard_name.h"
#include "pipeline/plan/dataset_plan.h"

namespace scanmill {

int runRegenerate(const std::vector<std::string>& arguments) {
  const Command& command = commandNamed("regenerate");
  cxxopts::Options options = describe(command);
  options.add_options()("shards", "the shards to make, such as 0-9,12 (default: all that are missing or damaged)",
                        cxxopts::value<std::string>(),
                        "RANGES")("sample", "make only this sample, and write its members as files to -o DIR",
                                  cxxopts::value<std::string>(), "KEY")(
      "o,out", "folder for the sample's files; it is made if it does not exist", cxxopts::value<std::string>(), "DIR")(
      "pipeline",
      "the pipeline's file, in whose folder the files that it names are found (default: searched for near the dataset)",
      cxxopts::value<std::string>(), "FILE")("threads", "how many threads to use, 0 for all cores",
                                             cxxopts::value<int>()->default_value("0"))("q,quiet", "print no progress");
  const Arguments parsed =
      parseArguments(command, options, arguments,
                     "  scanmill regenerate out/town                    # makes the shards that verify finds damaged\n"
                     "  scanmill regenerate out/town --sample town-s1-lane-000012 -o out/one\n");
  if (parsed.help) return 0;
  const std::string folder = parsed.positional("DIR");
  const ResourceLimits limits(parsed);
  const bool quiet = parsed.options.count("quiet") > 0;
  const auto text = [&](const char* name) {
    return parsed.options.count(name) > 0 ? parsed.options[name].as<std::string>() : std::string();
  };
  if (text("sample").empty() != text("out").empty()) throw InputError("give --sample KEY and -o DIR together");
  if (!text("sample").empty() && !text("shards").empty()) throw InputError("give --sample or --shards, not both");
  expectDataset(folder, "regenerate");
  const Manifest manifest = readManifest(folder);
  if (!text("sample").empty()) {
    const Plan plan = planOfDataset(manifest, folder, text("pipeline"));
    const std::vector<std::string> names = regenerateSample(manifest, plan, text("sample"), text("out"));
    printText("{}: {}\n", text("out"), fmt::join(names, ", "));
    return 0;
  }
  const std::vector<std::uint64_t> shards = text("shards").empty()
                                                ? damagedShards(folder, manifest)
                                                : parseShardRanges(text("shards"), manifest.shards.size());
  if (shards.empty()) {
    printText("all {} shards are undamaged: there is nothing to make\n", manifest.shards.size());
    return 0;
  }
  const Plan plan = planOfDataset(manifest, folder, text("pipeline"));
  regenerateShards(folder, manifest, plan, shards, quiet, &stopSignal());
  printText("made {} of {} shards again, with the same bytes: {}\n", shards.size(), manifest.shards.size(),
            shardRanges(shards));
  return 0;
}

}  // namespace scanmill
