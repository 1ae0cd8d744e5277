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
  const std::string folder = parsed.positional("DIR");
  const Manifest manifest = mergeDataset(folder);
  std::uint64_t bytes = 0;
  for (const ShardRecord& shard : manifest.shards) bytes += shard.bytes;
  printText("{0} in {1}, {2}, in {3}\nnext: scanmill view {3}; scanmill verify {3}\n",
            pluralOf(manifest.samples.size(), "sample"), pluralOf(manifest.shards.size(), "shard"), shortBytes(bytes),
            folder);
  return 0;
}

}  // namespace scanmill
