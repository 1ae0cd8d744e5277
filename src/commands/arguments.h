#pragma once

// Declares and reads the options of subcommands.

// cxxopts splits values at this character. Values such as --set 'seeds=[1,2]' and file names may contain commas, but no
// argument contains NUL.
#define CXXOPTS_VECTOR_DELIMITER '\0'
// std::regex would double the compile time of every subcommand.
#define CXXOPTS_NO_REGEX
#include <cxxopts.hpp>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "base/input_budget.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "commands/command.h"
#include "dataset/recording.h"

namespace scanmill {

// Applies the options --threads, --memory-limit and --input-limit, if they are given, for the lifetime of the object.
struct ResourceLimits {
  ResourceLimits(double inputFactor, int threadCount, std::uint64_t memoryBytes)
      : input(inputFactor), threads(threadCount), memory(memoryBytes) {}
  InputLimitFactor input;
  ThreadLimit threads;
  MemoryLimit memory;
};

// The parsed arguments of a subcommand. Its resource limits (--threads and others) apply until `limits` is destroyed.
struct Arguments {
  cxxopts::ParseResult options;
  std::unique_ptr<const ResourceLimits> limits;

  // True if the option is given; a default does not count.
  bool has(const std::string& option) const { return options.count(option) > 0; }
  // text() returns the value of an option, list() the values of a repeatable option; empty if the option is not given.
  std::string text(const std::string& option) const;
  std::vector<std::string> list(const std::string& option) const;
  // Returns the value or the default of an option as a number. Throws InputError if the value is not a number from
  // `least` to `most`. The option must be declared with textValue(), because cxxopts would read 1,5 as 1.
  double number(const std::string& option, double least, double most) const;
  // Returns all positional arguments.
  std::vector<std::string> inputs() const { return list("input"); }
  // Returns the only positional argument, which messages call `what`. Throws InputError for none or several.
  std::string positional(const std::string& what) const;
  // Returns the only positional argument as a path: the argument itself if it is a folder, or exists and has a slash or
  // suffix; otherwise the file of this name in the first of the program's `folders` that has such a file. If no folder
  // has one, returns the argument itself, or throws InputError if a folder has a file with a similar name.
  std::filesystem::path fileOrName(const std::string& what, std::initializer_list<std::string_view> folders) const;
  // Returns the pipeline file that the only positional argument gives: a path, or the name of an included pipeline.
  std::filesystem::path pipeline() const;
};

// Types of values for CommandOptions::add: textValue() for a text, listValue() for an option that may be repeated.
inline auto textValue() {
  return cxxopts::value<std::string>();
}
inline auto listValue() {
  return cxxopts::value<std::vector<std::string>>();
}

// Declares the options of a command. The constructor adds --help and the positional arguments; add() adds any other
// option. The help shows the command's usage and summary.
struct CommandOptions : cxxopts::Options {
  explicit CommandOptions(std::string_view command);
  std::string_view command;
  cxxopts::OptionAdder add;  // add("o,out", "help", value, "NAME OF THE VALUE")
};

// Parses the arguments. If --help is given, prints the help with `examples` and throws HelpPrinted. Throws InputError
// for unknown options.
Arguments parseArguments(CommandOptions& options, const std::vector<std::string>& arguments,
                         const std::string& examples);

// Adds --threads.
void addThreads(CommandOptions& options);
// Adds --input-limit, for commands that read scenes, 3D files or scans.
void addInputLimit(CommandOptions& options);

// Adds --threads, --memory-limit, --input-limit, --seed and --set, for commands that read a pipeline.
void addPipelineOptions(CommandOptions& options);
// Returns the values of --set, the value of --seed as an override of the key `seed`, and then the overrides in
// `further`.
std::vector<std::string> pipelineOverrides(const Arguments& arguments, const std::vector<std::string>& further = {});

// Adds --from-hits and --from-passes, for commands that accept a recording in place of scenes.
void addRecordingOptions(CommandOptions& options);
// Returns the recording that --from-hits or --from-passes names; null if neither option is given.
std::shared_ptr<const Recording> recordingOf(const Arguments& arguments);
// Returns the value of an option that is given. Throws InputError if the value is not a whole number of at least 0.
std::uint64_t countOption(const Arguments& arguments, const char* name);

// Creates the folder for an output file. Throws InputError if the folder cannot be created, if `file` is a folder, or
// if the file exists and --overwrite is not given.
void prepareOutputFile(const std::filesystem::path& file, const Arguments& arguments);

// Returns the folder that an option names; empty if the option is not given. Throws InputError for an empty name.
std::string folderOption(const Arguments& arguments, const std::string& name);

}  // namespace scanmill
