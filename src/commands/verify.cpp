#include "dataset/verify.h"

#include <optional>

#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "dataset/folder_contents.h"
#include "dataset/names.h"
#include "pipeline/run/progress.h"

namespace scanmill {

int runVerify(const std::vector<std::string>& arguments) {
  CommandOptions options("verify");
  addThreads(options);
  options.add("q,quiet", "print no progress");
  const Arguments parsed = parseArguments(options, arguments, "  scanmill verify out/quickstart\n");
  const std::string folder = parsed.positional("DIR");
  requireDataset(folder);
  std::optional<Progress> progress(std::in_place, "verify", 0, "shards", "shards", parsed.has("quiet"));
  const Verification v = verifyDataset(folder, [&](std::uint64_t, std::uint64_t total) {
    progress->setTotal(total);
    progress->advance(1, 1);
  });
  progress.reset();  // the bar ends before anything else is printed
  for (const std::string& problem : v.problems) printError("{}\n", oneLine(problem));
  const std::size_t problems = v.problems.size();
  printText("{}, {}; {} with {}, each format counted: {}\n", pluralOf(v.shards, "shard"), pluralOf(v.samples, "sample"),
            pluralOf(v.scans, "scan file"), pluralOf(v.points, "point"),
            problems == 0 ? "sound" : pluralOf(problems, "problem"));
  if (!v.damaged.empty()) {
    const std::string ranges = shardRanges(v.damaged);
    printText(
        "next: scanmill generate PIPELINE -o NEW --shards {} makes the damaged shards again, with the same bytes: "
        "copy them from NEW/{} to {}\n",
        ranges, kHiddenName, folder);
  }
  return problems == 0 ? 0 : 1;
}

}  // namespace scanmill
