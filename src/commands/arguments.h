#pragma once

// Reading a subcommand's options, the same way for all of them.

// Values such as --set 'seeds=[1,2]' and file names may hold commas: only a NUL, which no argument holds, parts a list.
#define CXXOPTS_VECTOR_DELIMITER '\0'
// std::regex would double the time that every subcommand takes to compile.
#define CXXOPTS_NO_REGEX
#include <cxxopts.hpp>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "base/memory.h"
#include "base/parallel.h"
#include "commands/command.h"
#include "dataset/recording.h"

namespace scanmill {

struct Arguments {
  cxxopts::ParseResult options;
  bool help = false;  // it was asked for and has been printed

  // The one positional argument. Throws InputError that says what is missing.
  std::string positional(const std::string& what) const;
  // The one positional argument where it may be a file that comes with the program: what is there, else the file of
  // this name in the first of the program's folders that has one, else what was given.
  std::filesystem::path fileOrName(const std::string& what, std::initializer_list<std::string_view> folders) const;
  // The one positional argument where it is a pipeline: the file, or one that comes with the program by its name.
  std::filesystem::path pipeline() const;
};

// Adds --help, parses and, if asked, prints the help with `examples`. Throws InputError for unknown options.
Arguments parseArguments(const Command& command, cxxopts::Options& options, const std::vector<std::string>& arguments,
                         const std::string& examples);

// cxxopts::Options with the command's usage line and one positional argument.
cxxopts::Options describe(const Command& command);

const Command& commandNamed(std::string_view name);

// --threads, --memory-limit, --seed and --set, for commands that read a pipeline.
void addPipelineOptions(cxxopts::Options& options);
std::vector<std::string> pipelineOverrides(const Arguments& arguments);

// --threads and --memory-limit, where a command has them, for as long as this lives.
class ResourceLimits {
 public:
  explicit ResourceLimits(const Arguments& arguments);

 private:
  ThreadLimit threads_;
  MemoryLimit memory_;
};

// --from-hits and --from-passes, for commands that may take a recording in place of scenes.
void addRecordingOptions(cxxopts::Options& options);
// Null where neither is given.
std::shared_ptr<const Recording> recordingOf(const Arguments& arguments);
// An option whose value is a whole number from 0. Throws InputError where it is none.
std::uint64_t countOption(const Arguments& arguments, const char* name);

// Empty where the option is not given. Throws InputError where it is given without a name.
std::string folderOption(const Arguments& arguments, const std::string& name);

// Throws InputError unless the folder holds a manifest.
void expectDataset(const std::filesystem::path& folder, std::string_view command);

}  // namespace scanmill
