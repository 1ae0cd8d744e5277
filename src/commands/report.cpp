#include <fmt/core.h>

#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "dataset/folder_contents.h"
#include "report/dataset/dataset_report.h"
#include "study/figure_text.h"

namespace scanmill {

int runReport(const std::vector<std::string>& arguments) {
  CommandOptions options("report");
  options.add("o,out",
              "the page to write (default: NAME_report.html in the current folder, where NAME is the dataset's folder)",
              textValue(), "FILE.html");
  options.add("overwrite", "replace an existing page");
  options.add("samples", "how many random samples to show, 0 to 64", cxxopts::value<std::size_t>()->default_value("4"),
              "N");
  options.add("seed", "seed that selects the random samples", cxxopts::value<std::uint64_t>()->default_value("0"));
  addThreads(options);
  options.add("q,quiet", "print one line instead of progress and warnings");
  const Arguments parsed = parseArguments(options, arguments,
                                          "  scanmill report out/quickstart\n"
                                          "  scanmill report out/quickstart -o quickstart.html --samples 8 --seed 7\n");
  const std::filesystem::path folder = parsed.positional("DATASET");
  requireDataset(folder);
  std::string name = lastName(folder);  // "small" for a dataset in the folder "out/small"
  if (name.empty() || name == "/") name = "dataset";
  const std::filesystem::path file = parsed.has("out") ? parsed.text("out") : name + "_report.html";
  if (file.empty()) throw InputError("-o: the name of the file is empty");

  DatasetReportOptions reportOptions{.seed = parsed.options["seed"].as<std::uint64_t>(),
                                     .samples = parsed.options["samples"].as<std::size_t>()};
  constexpr std::size_t kMostSamples = 64;  // pictured samples make the page large
  if (reportOptions.samples > kMostSamples) {
    throw InputError(fmt::format("--samples must be from 0 to {}, not {}", kMostSamples, reportOptions.samples));
  }
  prepareOutputFile(file, parsed);
  reportOptions.quiet = parsed.has("quiet");
  reportOptions.stop = &stopSignal();
  const DatasetReport report = examineDataset(folder, reportOptions);
  const std::string page = datasetPage(report);
  if (*reportOptions.stop) throw Error("stopped: nothing was written");
  writeFile(file, page);
  if (!reportOptions.quiet) {
    for (const DatasetWarning& w : report.warnings) {
      const std::string firstPlace =
          w.places.empty() ? "" : " (" + w.places.front() + (w.places.size() > 1 ? ", ...)" : ")");
      const std::string text = w.text + firstPlace;
      if (w.note) {
        printError("note: {}\n", text);
      } else {
        warn(text);
      }
    }
  }
  printText("{}: {}; open it in a browser\n", file.string(), shortBytes(page.size()));
  return 0;
}

}  // namespace scanmill
