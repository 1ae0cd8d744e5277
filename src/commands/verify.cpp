#include "dataset/verify.h"

#include <fmt/core.h>

#include "base/parallel.h"
#include "commands/arguments.h"
#include "commands/table.h"
#include "pipeline/progress.h"

namespace scanmill {

int runVerify(const std::vector<std::string>& arguments) {
  const Command& command = commandNamed("verify");
  cxxopts::Options options = describe(command);
  options.add_options()("threads", "how many threads to use, 0 for all cores",
                        cxxopts::value<int>()->default_value("0"))("q,quiet", "no progress");
  const Arguments parsed = parseArguments(command, options, arguments, "  scanmill verify out/quickstart\n");
  if (parsed.help) return 0;
  const std::string folder = parsed.positional("DIR");
  expectDataset(folder, "verify");
  const ThreadLimit limit(threadOption(parsed));
  Progress progress("verify", 0, "shards", "shards", parsed.options.count("quiet") > 0);
  const Verification v = verifyDataset(folder, [&](std::uint64_t, std::uint64_t total) {
    progress.setTotal(total);
    progress.advance(1, 1);
  });
  for (const std::string& problem : v.problems) fmt::print(stderr, "{}\n", problem);
  fmt::print("{} shards, {} samples, {} scans, {} points: {}\n", grouped(v.shards), grouped(v.samples),
             grouped(v.scans), grouped(v.points),
             v.problems.empty() ? "sound" : fmt::format("{} problems", v.problems.size()));
  return v.problems.empty() ? 0 : 1;
}

}  // namespace scanmill
