// scanmill turns 3D scenes into labelled LiDAR datasets. This file finds the subcommand and catches every error.

#include <fmt/core.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "base/error.h"
#include "base/memory.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/command.h"
#include "commands/stop_signal.h"
#include "config/fields.h"
#include "config/version.h"

namespace {

using namespace scanmill;

void printHelp() {
  printText("scanmill {}: labelled LiDAR datasets from 3D scenes\n\n", kVersion);
  constexpr std::size_t kUsageWidth = 16;
  constexpr std::size_t kUsageColumn = 21;  // width of "  scanmill NAME      "
  for (const Command& c : commands()) {
    // The summary of a command with a long usage is on a line of its own.
    const std::string gap = c.usage.size() <= kUsageWidth ? "" : fmt::format("\n{:{}}", "", kUsageColumn + kUsageWidth);
    printText("  scanmill {:9} {:{}}{} {}\n", c.name, c.usage, kUsageWidth, gap, c.summary);
  }
  printText(
      "\nEach has a --help with examples. Start with:\n"
      "  scanmill generate pipelines/quickstart.yaml -o out/quickstart\n");
}

// Runs the subcommand that the first argument names, or prints the help or the version. Returns the exit code.
int dispatch(const std::vector<std::string>& arguments) {
  if (arguments.empty() || arguments[0] == "--help" || arguments[0] == "-h" || arguments[0] == "help") {
    printHelp();
    return arguments.empty() ? 2 : 0;
  }
  if (arguments[0] == "--version") {
    printText("scanmill {}\n", kVersion);
    return 0;
  }
  std::vector<std::string> names;
  for (const Command& c : commands()) {
    try {
      if (c.name == arguments[0]) return c.run({arguments.begin() + 1, arguments.end()});
    } catch (const HelpPrinted&) {
      return 0;
    }
    names.emplace_back(c.name);
  }
  if (arguments[0] == "picture") {
    throw InputError("`picture` is now `scanmill view INPUT --screenshot FILE.png`; see `scanmill view --help`");
  }
  throw InputError(fmt::format("no command '{}'{}", arguments[0], suggestion(arguments[0], names)));
}

// Reports that the memory ran out. Returns the exit code.
int reportNoMemory(const std::string& command) {
  printError(
      "error: scanmill {}: the memory ran out, of which {} are allowed: give fewer --threads or a lower "
      "--memory-limit; take fewer rings, columns or formats, a smaller scene, larger voxels (particle) or smaller "
      "images (depth_camera); or allow more (ulimit -v, the limit of the container)\n",
      command, shortBytes(memoryLimitBytes()));
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  // If these signals are ignored, writing to a pipe without a reader or beyond `ulimit -f` fails with an error number.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    const int code = dispatch({argv + 1, argv + argc});
    // A reader that stops early (`| head`) is not a failure; a full disk is.
    if (std::fflush(stdout) != 0 && errno != EPIPE) {
      throw Error("standard output: {}", std::strerror(errno));
    }
    return code;
  } catch (const InputError& e) {
    printError("error: {}\n", indented(e.what()));
    return 2;
  } catch (const std::bad_alloc&) {
    return reportNoMemory(argc > 1 ? argv[1] : "");
  } catch (const std::length_error&) {
    return reportNoMemory(argc > 1 ? argv[1] : "");
  } catch (const std::system_error& e) {
    if (e.code() == std::errc::broken_pipe) return 0;  // the reader of the output stopped early
    printError("error: {}\n", indented(e.what()));
    return 1;
  } catch (const std::exception& e) {
    printError("error: {}\n", indented(reasonOf(e)));
    return stoppedBy() == 0 ? 1 : 128 + stoppedBy();
  }
}
