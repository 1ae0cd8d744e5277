#include "dataset/verify.h"

#include <fmt/core.h>

#include <filesystem>

#include "base/grouped.h"
#include "base/parallel.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/table.h"
#include "dataset/recording.h"
#include "dataset/shard_name.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/verify_recording.h"

namespace scanmill {

namespace {

// Returns the result of verify(folder, progress). Its calls of `progress` advance a progress bar, which ends before
// anything else is printed.
template <class Verify>
auto withProgress(const Verify& verify, const std::string& folder, const char* unit, bool quiet) {
  Progress progress("verify", 0, unit, unit, quiet);
  return verify(folder, [&](std::uint64_t, std::uint64_t total) {
    progress.setTotal(total);
    progress.advance(1, 1);
  });
}

// Prints the problems, then `counts` and the number of problems. Returns the exit code.
int report(const std::vector<std::string>& problems, const std::string& counts) {
  for (const std::string& problem : problems) printError("{}\n", oneLine(problem));
  printText("{}: {}\n", counts,
            problems.empty() ? "sound" : fmt::format("{} problem{}", problems.size(), problems.size() == 1 ? "" : "s"));
  return problems.empty() ? 0 : 1;
}

}  // namespace

int runVerify(const std::vector<std::string>& arguments) {
  CommandOptions options("verify");
  cxxopts::OptionAdder add = options.add_options();
  add("threads", "how many threads to use, 0 for all cores", cxxopts::value<int>()->default_value("0"));
  add("q,quiet", "print no progress");
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill verify out/quickstart\n"
                     "  scanmill verify out/passes    # a recording: reads all files that it names\n");
  if (parsed.help) return 0;
  const std::string folder = parsed.positional("DIR");
  const ResourceLimits limits(parsed);
  const bool quiet = parsed.has("quiet");
  std::error_code ignored;
  if (!std::filesystem::exists(std::filesystem::path(folder) / kManifestName, ignored) && recordingIn(folder)) {
    const RecordingVerification v = withProgress(verifyRecording, folder, "images", quiet);
    for (const std::string& warning : v.warnings) warn(warning);
    return report(v.problems, fmt::format("{} scans, {} images, {} pixels", grouped(v.scans), grouped(v.images),
                                          grouped(v.pixels)));
  }
  expectDataset(folder, "verify");
  const Verification v = withProgress(verifyDataset, folder, "shards", quiet);
  const int code =
      report(v.problems, fmt::format("{} shards, {} samples; {} scan files with {} points, each format counted",
                                     grouped(v.shards), grouped(v.samples), grouped(v.scans), grouped(v.points)));
  if (v.damaged > 0) printText("next: scanmill regenerate {} makes the damaged files again\n", folder);
  return code;
}

}  // namespace scanmill
