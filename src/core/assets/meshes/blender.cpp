#include "assets/meshes/blender.h"

#include <fmt/core.h>

#include <charconv>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "base/error.h"
#include "config/resources.h"

namespace scanmill {

namespace {

constexpr double kPatience = 600;  // s, default of SCANMILL_BLENDER_SECONDS

double patience() {
  const char* set = std::getenv("SCANMILL_BLENDER_SECONDS");
  if (set == nullptr) return kPatience;
  const std::string_view text = set;
  double seconds = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (failure != std::errc() || end != text.data() + text.size() || !(seconds > 0) || !(seconds <= 1e6)) {
    throw InputError(
        fmt::format("SCANMILL_BLENDER_SECONDS is '{}', but must be a number of seconds above 0 and at most 1e6", text));
  }
  return seconds;
}

std::vector<std::string> commandLine(const std::string& job, const std::filesystem::path& folder,
                                     const std::vector<std::string>& arguments) {
  const std::filesystem::path script = resourceFolder() / "scripts" / "blender_passes.py";
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(script, ignored)) {
    throw Error(fmt::format("{}: is missing: build or install Scanmill again (cmake --install)", script.string()));
  }
  // --disable-autoexec: Blender runs no registered scripts or driver expressions of a file.
  std::vector<std::string> command{blenderProgram().string(),
                                   "--background",
                                   "--factory-startup",
                                   "--disable-autoexec",
                                   "-noaudio",
                                   "--python-exit-code",
                                   "3",
                                   "--python",
                                   script.string(),
                                   "--"};
  command.insert(command.end(), {job, folder.string()});
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

// Returns changes to the environment, by which Blender loads no start-up scripts or add-ons of the user and writes its
// own files only into `folder`.
std::map<std::string, std::string> environmentIn(const std::filesystem::path& folder) {
  std::map<std::string, std::string> environment;
  for (const char* name : {"BLENDER_USER_RESOURCES", "BLENDER_USER_CONFIG", "BLENDER_USER_SCRIPTS",
                           "BLENDER_USER_DATAFILES", "TMPDIR", "TMP", "TEMP"}) {
    environment[name] = folder.string();
  }
  return environment;
}

}  // namespace

std::filesystem::path blenderProgram() {
  const char* named = std::getenv("SCANMILL_BLENDER");
  const bool set = named != nullptr && *named != '\0';
  std::filesystem::path program = findProgram(set ? named : "blender");
  if (!program.empty()) return program;
  if (set)
    throw Error(
        fmt::format("SCANMILL_BLENDER names '{}', which does not exist or is not executable: name Blender's program, "
                    "or install it by scripts/setup --blender",
                    named));
  throw Error(
      "Blender is not installed: install it by scripts/setup --blender or, on Debian, by apt-get install blender; or "
      "set SCANMILL_BLENDER to its program");
}

BlenderJob::BlenderJob(const std::string& job, const std::filesystem::path& folder,
                       const std::vector<std::string>& arguments)
    : patience_(patience()), process_(commandLine(job, folder, arguments), environmentIn(folder)) {}

void BlenderJob::fail(const std::string& what) const {
  const std::string lines = process_.lastLines();
  throw Error(lines.empty() ? what : fmt::format("{}; its last lines:\n{}", what, lines));
}

void BlenderJob::ask(const std::string& line) {
  process_.write(line + "\n");
}

BlenderAnswer BlenderJob::answer() {
  try {
    while (const std::optional<std::string> line = process_.readLine(patience_)) {
      const nlohmann::json fields = nlohmann::json::parse(*line, nullptr, false);
      if (!fields.is_object()) continue;  // Blender itself printed this line before the script started
      BlenderAnswer answer{fields.value("what", ""), fields.value("text", ""), fields.value("seconds", 0.0)};
      if (answer.what == "error" && fields.value("input", false)) throw InputError(answer.text);
      return answer;
    }
    const std::string end = process_.wait(patience_);
    fail(fmt::format("Blender failed ({})", end));
  } catch (const TimeOut&) {
    fail(fmt::format("Blender did not finish within {} s: set SCANMILL_BLENDER_SECONDS to wait longer", patience_));
  } catch (const nlohmann::json::exception& e) {
    fail(fmt::format("the answer of Blender is not understood ({})", reasonOf(e)));
  }
}

}  // namespace scanmill
