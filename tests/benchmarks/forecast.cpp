// Prints forecasts beside facts: for each pipeline, what `scanmill plan` foretells of a whole dataset and what making
// it then takes, in time and in bytes, on all threads; the quickstart with two other sensors besides.
//   bench_forecast [PIPELINE ...]     all that come with the program where none is named; those whose assets
//                                     SCANMILL_ASSETS does not name are left out

#include "pipeline/run/forecast.h"

#include <fmt/core.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/stage_clock.h"
#include "pipeline/run/generate.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

std::vector<std::filesystem::path> shippedPipelines() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(SCANMILL_SOURCE_DIR) + "/pipelines")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void compare(const std::string& name, const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const TemporaryFolder folder;
  const auto reread = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = overrides;
    all.insert(all.end(), more.begin(), more.end());
    return readPipeline(file, all);
  };
  const Plan plan = makePlan(reread({}));
  const WallTimer timer;
  const SampleCosts costs = measureSampleCosts(plan, reread);
  const double took = timer.seconds();
  const Forecast expected = forecast(costs, plan.pipeline.frames(), scenesOf(plan.pipeline));
  GenerateOptions options;
  options.folder = folder.path() / "dataset";
  options.quiet = true;
  const GenerateSummary fact = generate(plan, options);
  const double seconds = fact.seconds;
  const auto bytes = static_cast<double>(fact.bytes);
  fmt::print("{:<22} {:7.2f} {:7.2f} {:5.2f}   {:8.1f} {:8.1f} {:5.2f}   {:6.2f}\n", name, expected.seconds.expected,
             seconds, expected.seconds.expected / seconds, expected.bytes.expected * 1e-6, bytes * 1e-6,
             expected.bytes.expected / bytes, took);
  std::fflush(stdout);
}

int run(const std::vector<std::filesystem::path>& files) {
  fmt::print("{:<22} {:>7} {:>7} {:>5}   {:>8} {:>8} {:>5}   {:>6}\n", "pipeline", "s told", "s", "ratio", "MB told",
             "MB", "ratio", "took s");
  const auto print = [](const std::string& name, const std::filesystem::path& file,
                        const std::vector<std::string>& overrides) {
    // Each in a process of its own, as `scanmill plan` is, since the first scene of a process takes longer.
    std::fflush(stdout);
    const pid_t child = ::fork();
    if (child == 0) {
      try {
        compare(name, file, overrides);
      } catch (const Error& failure) {
        fmt::print("{:<22} left out: {}\n", name, failure.what());
      }
      std::fflush(stdout);
      ::_exit(0);
    }
    int status = 0;
    if (child < 0 || ::waitpid(child, &status, 0) != child || status != 0) fmt::print("{:<22} failed\n", name);
  };
  for (const std::filesystem::path& file : files) {
    const std::string name = file.stem().string();
    print(name, file, {});
    if (name != "quickstart") continue;
    for (const std::string sensor : {"os1_128", "vlp_16"}) {
      print(name + " " + sensor, file, {"sensors.0.preset=" + sensor});
    }
  }
  return 0;
}

}  // namespace
}  // namespace scanmill

int main(int count, char** arguments) {
  std::vector<std::filesystem::path> files(arguments + 1, arguments + count);
  return scanmill::run(files.empty() ? scanmill::shippedPipelines() : files);
}
