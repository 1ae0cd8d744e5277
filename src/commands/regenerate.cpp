#include <map>

#include "base/file.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "dataset/folder_contents.h"
#include "dataset/names.h"
#include "dataset/verify.h"
#include "pipeline/plan/dataset_plan.h"
#include "pipeline/run/generate.h"

namespace scanmill {

namespace {

// Throws InputError if the path exists but is no regular file, because a new file could not replace it.
void requireReplaceable(const std::filesystem::path& file) {
  const auto status = std::filesystem::symlink_status(file);
  if (!exists(status) || is_regular_file(status)) return;
  throw InputError({file.string()}, "is not a file, so that the damaged one cannot be made again there: remove it");
}

}  // namespace

int runRegenerate(const std::vector<std::string>& arguments) {
  CommandOptions options("regenerate");
  options.add("shards", "the shards to make, such as 0-9,12 (default: all that are missing or damaged)", textValue(),
              "RANGES");
  options.add(
      "pipeline",
      "the pipeline's file, in whose folder the files that it names are found (default: searched for near the dataset)",
      textValue(), "FILE");
  addThreads(options);
  options.add("q,quiet", "print no progress");
  addInputLimit(options);
  const Arguments parsed = parseArguments(
      options, arguments,
      "  scanmill regenerate out/quickstart                 # makes the files that verify finds damaged\n"
      "  scanmill regenerate out/quickstart --shards 0-9,12\n");
  const std::filesystem::path folder = parsed.positional("DIR");
  const bool quiet = parsed.has("quiet");
  const std::string ranges = parsed.text("shards");
  requireDataset(folder);
  const std::filesystem::path manifestFile = folder / kManifestName;
  requireStatedDigest(manifestFile, readFile(manifestFile));
  std::map<std::uint32_t, std::string> undescribed;
  const Manifest manifest = readManifest(folder, undescribed);
  std::vector<std::uint64_t> shards;
  if (!ranges.empty()) {
    shards = parseShardRanges(ranges, manifest.shards.size());
  } else {
    const std::vector<std::string> faults = shardFaults(folder, manifest, true);
    for (std::uint32_t shard = 0; shard < faults.size(); ++shard) {
      if (!faults[shard].empty() || undescribed.contains(shard)) shards.push_back(shard);
    }
  }
  if (shards.empty()) {
    printText("all {} shards are undamaged: there is nothing to make\n", manifest.shards.size());
    return 0;
  }
  for (const std::uint64_t shard : shards) {
    const ShardRecord& record = manifest.shards[shard];
    requireReplaceable(folder / record.file);
    if (!record.samplesSha256.empty()) requireReplaceable(folder / samplesFileOf(record.file));
  }
  regenerateShards(folder, manifest, planOfDataset(manifest, folder, parsed.text("pipeline")), shards, quiet,
                   &stopSignal());
  printText("made {} of {} shards again, with the same bytes: {}\n", shards.size(), manifest.shards.size(),
            shardRanges(shards));
  return 0;
}

}  // namespace scanmill
