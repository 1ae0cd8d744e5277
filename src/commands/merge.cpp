#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "dataset/parts.h"

namespace scanmill {

int runMerge(const std::vector<std::string>& arguments) {
  CommandOptions options("merge");
  const Arguments parsed = parseArguments(options, arguments,
                                          "  scanmill merge out/town    # after `scanmill generate town.yaml -o "
                                          "out/town --worker I --workers N` for each I\n");
  if (parsed.help) return 0;
  const std::string folder = parsed.positional("DIR");
  const Manifest manifest = mergeDataset(folder);
  std::uint64_t bytes = 0;
  for (const ShardRecord& shard : manifest.shards) bytes += shard.bytes;
  printText("{} samples in {} shards, {}, in {}\nnext: scanmill view {}; scanmill verify {}\n", manifest.samples.size(),
            manifest.shards.size(), shortBytes(static_cast<double>(bytes)), folder, folder, folder);
  return 0;
}

}  // namespace scanmill
