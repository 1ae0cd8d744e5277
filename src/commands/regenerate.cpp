#include "pipeline/run/regenerate.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/file.h"
#include "base/parallel.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "dataset/shard_name.h"
#include "pipeline/plan/dataset_plan.h"

namespace scanmill {

int runRegenerate(const std::vector<std::string>& arguments) {
  CommandOptions options("regenerate");
  cxxopts::OptionAdder add = options.add_options();
  add("shards", "the shards to make, such as 0-9,12 (default: all that are missing or damaged)", textValue(), "RANGES");
  add("sample", "make only this sample, and write its members as files to -o DIR", textValue(), "KEY");
  add("o,out", "folder for the sample's files; it is made if it does not exist", textValue(), "DIR");
  add("pipeline",
      "the pipeline's file, in whose folder the files that it names are found (default: searched for near the dataset)",
      textValue(), "FILE");
  add("threads", "how many threads to use, 0 for all cores", cxxopts::value<int>()->default_value("0"));
  add("q,quiet", "print no progress");
  addInputLimit(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill regenerate out/quickstart              # makes the files that verify finds damaged\n"
                     "  scanmill regenerate out/quickstart --sample town-s1-drive-000004 -o out/one\n");
  if (parsed.help) return 0;
  const std::string folder = parsed.positional("DIR");
  const ResourceLimits limits(parsed);
  const bool quiet = parsed.has("quiet");
  const std::string sample = parsed.text("sample"), out = parsed.text("out"), asked = parsed.text("shards");
  if (sample.empty() != out.empty()) throw InputError("give --sample KEY and -o DIR together");
  if (!sample.empty() && !asked.empty()) throw InputError("give --sample or --shards, not both");
  expectDataset(folder, "regenerate");
  const std::filesystem::path manifestFile = std::filesystem::path(folder) / kManifestName;
  expectUnchanged(manifestFile, readFile(manifestFile));
  std::map<std::uint32_t, std::string> undescribed;
  Manifest manifest = sample.empty() ? readManifest(folder, undescribed) : readManifest(folder);
  const auto plan = [&] { return planOfDataset(manifest, folder, parsed.text("pipeline")); };
  if (!sample.empty()) {
    const std::vector<std::string> names = regenerateSample(manifest, plan(), sample, out);
    printText("{}: {}\n", out, fmt::join(names, ", "));
    return 0;
  }
  const std::vector<std::uint64_t> shards =
      asked.empty() ? damagedShards(folder, manifest) : parseShardRanges(asked, manifest.shards.size());
  std::vector<std::uint64_t> soundUndescribed, madeUndescribed;  // shards whose samples' descriptions are damaged
  for (const auto& [shard, problem] : undescribed) {
    if (std::binary_search(shards.begin(), shards.end(), shard)) {
      madeUndescribed.push_back(shard);
    } else if (asked.empty()) {
      soundUndescribed.push_back(shard);
    }
  }
  const auto expectPlace = [&](const std::filesystem::path& file) {
    const auto status = std::filesystem::symlink_status(std::filesystem::path(folder) / file);
    if (!exists(status) || is_regular_file(status)) return;
    throw InputError({(std::filesystem::path(folder) / file).string()},
                     "is not a file, so that the damaged one cannot be made again there: remove it");
  };
  for (const std::uint64_t shard : shards) expectPlace(manifest.shards[shard].file);
  for (const auto& [shard, problem] : undescribed) expectPlace(samplesFileOf(manifest.shards[shard].file));
  if (shards.empty() && soundUndescribed.empty()) {
    printText("all {} shards are undamaged: there is nothing to make\n", manifest.shards.size());
    return 0;
  }
  const auto describeAgain = [&](const std::vector<std::uint64_t>& numbers) {
    if (numbers.empty()) return;
    describeShards(folder, manifest, numbers, plan);
    printText("described the samples of {} of {} shards again, with the same bytes: {}\n", numbers.size(),
              manifest.shards.size(), shardRanges(numbers));
  };
  describeAgain(soundUndescribed);
  if (shards.empty()) return 0;
  regenerateShards(folder, manifest, plan(), shards, quiet, &stopSignal());
  printText("made {} of {} shards again, with the same bytes: {}\n", shards.size(), manifest.shards.size(),
            shardRanges(shards));
  describeAgain(madeUndescribed);
  return 0;
}

}  // namespace scanmill
