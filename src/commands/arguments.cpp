#include "commands/arguments.h"

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <system_error>

#include "base/error.h"
#include "base/file.h"
#include "base/terminal.h"
#include "config/fields.h"
#include "config/resources.h"
#include "config/text.h"

namespace scanmill {

std::string Arguments::text(const std::string& option) const {
  return has(option) ? options[option].as<std::string>() : std::string();
}

std::vector<std::string> Arguments::list(const std::string& option) const {
  return has(option) ? options[option].as<std::vector<std::string>>() : std::vector<std::string>{};
}

double Arguments::number(const std::string& option, double least, double most) const {
  return readNumber(scalarValue(options[option].as<std::string>()), "--" + option, {least, most});
}

std::string Arguments::positional(const std::string& what) const {
  const std::vector<std::string> values = inputs();
  if (values.size() == 1) return values.front();
  throw InputError(values.empty() ? fmt::format("{} is missing; see --help", what)
                                  : fmt::format("give only one {}: '{}' is a second", what, values[1]));
}

std::filesystem::path Arguments::fileOrName(const std::string& what,
                                            std::initializer_list<std::string_view> folders) const {
  const std::string argument = positional(what);
  if (isFolder(argument) || (!isPlainName(argument) && pathExists(argument))) return argument;
  for (const std::string_view folder : folders) {
    try {
      return namedResource(argument, std::string(folder));
    } catch (const InputError&) {
      continue;  // the folder has no such file
    }
  }
  for (const std::string_view folder : folders) {
    if (const std::string similar = nearestResource(argument, std::string(folder)); !similar.empty()) {
      throw InputError({argument}, "does not exist (did you mean '{}', which comes with the program?)", similar);
    }
  }
  return argument;  // opening the path will report that it does not exist
}

std::filesystem::path Arguments::pipeline() const {
  const std::string argument = positional("PIPELINE");
  if (!isPlainName(argument) && pathExists(argument)) return argument;
  return namedResource(argument, "pipelines");
}

namespace {

// Parses a number of bytes, such as "8G", "500M" or "1.5 GiB", with units as powers of 1024. Returns nothing if the
// text has another form.
std::optional<double> bytesOf(const std::string& text) {
  double number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc()) return std::nullopt;
  std::string unit = lowerCase(std::string(end, text.data() + text.size()));
  unit.erase(0, unit.find_first_not_of(' '));
  if (unit.empty()) return number;
  constexpr std::string_view kPrefixes = "kmgt";  // k is 1024, each following prefix 1024 times the one before
  const std::size_t prefix = kPrefixes.find(unit.front());
  if (prefix == std::string_view::npos || (unit.size() > 1 && unit.substr(1) != "ib")) return std::nullopt;
  return std::ldexp(number, 10 * (static_cast<int>(prefix) + 1));  // 1024 is 2 to the 10
}

// Returns the value of --memory-limit in bytes; 0 if it is not given. Throws InputError if it is not a number of bytes.
std::uint64_t memoryOption(const Arguments& arguments) {
  if (!arguments.has("memory-limit")) return 0;
  const std::string text = arguments.text("memory-limit");
  const std::optional<double> bytes = bytesOf(text);
  constexpr double kMost = 18446744073709551616.0;  // 2^64, the first number that does not fit into the result
  if (bytes && *bytes >= 1 && *bytes < kMost) return static_cast<std::uint64_t>(*bytes);
  throw InputError(
      fmt::format("--memory-limit must be a number with K, M, G or T, such as 8G, below 16 EiB, not '{}'", text));
}

}  // namespace

CommandOptions::CommandOptions(std::string_view name)
    : cxxopts::Options(fmt::format("scanmill {}", name),
                       std::string(requireNamed(commands(), "command", name).summary)),
      command(name),
      add(add_options()) {
  positional_help(std::string(requireNamed(commands(), "command", name).usage)).show_positional_help();
  add("h,help", "print this help");
  add_options("positional")("input", "", listValue());
  parse_positional({"input"});
}

Arguments parseArguments(CommandOptions& options, const std::vector<std::string>& arguments,
                         const std::string& examples) {
  std::vector<const char*> argv{options.command.data()};
  for (const std::string& a : arguments) argv.push_back(a.c_str());
  Arguments parsed;
  try {
    parsed.options = options.parse(static_cast<int>(argv.size()), argv.data());
  } catch (const std::exception& e) {
    throw InputError(fmt::format("{}; see `scanmill {} --help`", e.what(), options.command));
  }
  if (parsed.has("help")) {
    std::string help = options.help({""});
    constexpr std::string_view kNoDefault = "(=)]";  // part of the help of options that need no value
    if (const std::size_t position = help.find(kNoDefault); position != std::string::npos)
      help.replace(position, kNoDefault.size(), "]   ");
    printText("{}\n\nExamples:\n{}", help, examples);
    throw HelpPrinted();
  }
  const double inputFactor = parsed.has("input-limit") ? parsed.number("input-limit", 1, 1e6) : 1;
  const int threads = parsed.has("threads") ? parsed.options["threads"].as<int>() : 0;  // 0: all cores
  if (threads < 0 || threads > 1024) throw InputError(fmt::format("--threads must be from 0 to 1024, not {}", threads));
  parsed.limits = std::make_unique<ResourceLimits>(inputFactor, threads, memoryOption(parsed));
  return parsed;
}

void addThreads(CommandOptions& options) {
  options.add("threads", "how many threads to use, 0 for all cores", cxxopts::value<int>()->default_value("0"), "N");
}

void addInputLimit(CommandOptions& options) {
  options.add("input-limit",
              "multiply by N, at least 1, the limits of what small files may cost: files, copies, memory and "
              "time (docs/reliability.md)",
              textValue(), "N");
}

void addPipelineOptions(CommandOptions& options) {
  addThreads(options);
  options.add("memory-limit",
              "how much memory to use at most, such as 8G or 500M (default: all of the machine's or container's)",
              textValue(), "SIZE");
  addInputLimit(options);
  options.add("seed", "seed of the sensors' noise, instead of the pipeline's", textValue());
  options.add("set", "override a key, such as --set motion=none or --set output.shard_mb=64 (may be repeated)",
              listValue(), "key=value");
}

std::vector<std::string> pipelineOverrides(const Arguments& arguments, const std::vector<std::string>& further) {
  std::vector<std::string> overrides = arguments.list("set");
  if (arguments.has("seed")) overrides.push_back("seed=" + arguments.text("seed"));
  overrides.insert(overrides.end(), further.begin(), further.end());
  return overrides;
}

void addRecordingOptions(CommandOptions& options) {
  options.add("from-hits", "make scans from the hits that --keep-hits saved, without loading or tracing the scene",
              textValue(), "DIR");
  options.add("from-passes", "make scans from images that `render` saved or another renderer drew, without the scene",
              textValue(), "DIR");
}

std::uint64_t countOption(const Arguments& arguments, const char* name) {
  const std::string text = arguments.text(name);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw InputError(fmt::format("--{} {}: must be a whole number of at least 0", name, text));
  }
  return number;
}

std::string folderOption(const Arguments& arguments, const std::string& name) {
  if (!arguments.has(name)) return {};
  std::string folder = arguments.text(name);
  if (folder.empty()) throw InputError(fmt::format("--{}: the name of the folder is empty", name));
  return folder;
}

void prepareOutputFile(const std::filesystem::path& file, const Arguments& arguments) {
  std::error_code failure;
  if (std::filesystem::is_directory(file, failure)) throw InputError({file.string()}, "is a folder: name a file");
  if (std::filesystem::exists(file, failure) && !arguments.has("overwrite")) {
    throw InputError({file.string()}, "exists: name another place with -o, or add --overwrite");
  }
  const std::filesystem::path folder = file.parent_path();
  if (folder.empty() || std::filesystem::create_directories(folder, failure) || !failure) return;
  throw InputError({folder.string()}, "cannot be made ({}): name another folder with -o", failure.message());
}

std::shared_ptr<const Recording> recordingOf(const Arguments& arguments) {
  const std::string hits = folderOption(arguments, "from-hits");
  const std::string passes = folderOption(arguments, "from-passes");
  if (!hits.empty() && !passes.empty()) throw InputError("give only one of --from-hits and --from-passes");
  if (!hits.empty()) return std::make_shared<const Recording>(readRecording(hits, RecordingKind::Hits));
  if (!passes.empty()) return std::make_shared<const Recording>(readRecording(passes, RecordingKind::Passes));
  return nullptr;
}

}  // namespace scanmill
