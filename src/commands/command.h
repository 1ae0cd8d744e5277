#pragma once

// Subcommands of the program. To add a subcommand, add a file and a row in commands().

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

struct Command {
  std::string_view name;
  std::string_view usage;    // arguments in the help, such as "PIPELINE -o DIR"
  std::string_view summary;  // description in the help, in one line
  // `arguments` starts after the subcommand's name. Returns the exit code; throws Error.
  int (*run)(const std::vector<std::string>& arguments);
};

std::span<const Command> commands();

// Thrown when a command has printed its help; main() then returns exit code 0.
struct HelpPrinted {};

int runGenerate(const std::vector<std::string>& arguments);
int runRender(const std::vector<std::string>& arguments);
int runTradeoff(const std::vector<std::string>& arguments);
int runRepeatability(const std::vector<std::string>& arguments);
int runFitSensor(const std::vector<std::string>& arguments);
int runFitNoise(const std::vector<std::string>& arguments);
int runCompare(const std::vector<std::string>& arguments);
int runDraft(const std::vector<std::string>& arguments);
int runPlan(const std::vector<std::string>& arguments);
int runExport(const std::vector<std::string>& arguments);
int runMerge(const std::vector<std::string>& arguments);
int runVerify(const std::vector<std::string>& arguments);
int runReport(const std::vector<std::string>& arguments);
int runView(const std::vector<std::string>& arguments);
int runInfo(const std::vector<std::string>& arguments);
int runExample(const std::vector<std::string>& arguments);
int runList(const std::vector<std::string>& arguments);

}  // namespace scanmill
