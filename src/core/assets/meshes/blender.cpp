#include "assets/meshes/blender.h"

#include <fmt/core.h>

#include <cstdint>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"
#include "config/resources.h"

namespace scanmill {

namespace {

// Returns the longest wait for an answer (s): SCANMILL_BLENDER_SECONDS, or 600. Throws InputError for a bad value.
double patience() {
  constexpr double kDefault = 600;
  const char* text = std::getenv("SCANMILL_BLENDER_SECONDS");
  if (text == nullptr) return kDefault;
  double seconds = 0;
  if (parseNumber(text, seconds) && seconds > 0 && seconds <= 1e6) return seconds;
  throw InputError(
      fmt::format("SCANMILL_BLENDER_SECONDS is '{}', but must be a number of seconds above 0 and at most 1e6", text));
}

// Returns the command line that runs a job of blender_passes.py in Blender. `arguments`: the arguments of the job.
std::vector<std::string> commandLine(const std::string& job, const std::filesystem::path& folder,
                                     const std::vector<std::string>& arguments) {
  const std::filesystem::path script = resourceFolder() / "scripts" / "blender_passes.py";
  if (!isFile(script)) {
    throw Error("{}: is missing: build or install Scanmill again (cmake --install)", script.string());
  }
  std::vector<std::string> command{blenderProgram().string()};
  // --disable-autoexec: Blender runs no registered scripts or driver expressions of a file.
  command.insert(command.end(), {"--background", "--factory-startup", "--disable-autoexec", "-noaudio",
                                 "--python-exit-code", "3", "--python", script.string(), "--", job, folder.string()});
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

// Returns environment variables that keep Blender from loading start-up scripts or add-ons of the user, and make it
// write its own files only into `folder`.
std::map<std::string, std::string> environmentIn(const std::string& folder) {
  std::map<std::string, std::string> environment;
  for (const char* name : {"BLENDER_USER_RESOURCES", "BLENDER_USER_CONFIG", "BLENDER_USER_SCRIPTS",
                           "BLENDER_USER_DATAFILES", "TMPDIR", "TMP", "TEMP"}) {
    environment[name] = folder;
  }
  return environment;
}

}  // namespace

std::filesystem::path blenderProgram() {
  const char* variable = std::getenv("SCANMILL_BLENDER");
  const bool isSet = variable != nullptr && *variable != '\0';
  std::filesystem::path program = findProgram(isSet ? variable : "blender");
  if (!program.empty()) return program;
  if (isSet)
    throw Error(
        "SCANMILL_BLENDER names '{}', which does not exist or is not executable: name Blender's program, "
        "or install it by scripts/setup --blender",
        variable);
  throw Error(
      "Blender is not installed: install it by scripts/setup --blender or, on Debian, by apt-get install blender; or "
      "set SCANMILL_BLENDER to its program");
}

BlenderJob::BlenderJob(const std::string& job, const std::filesystem::path& folder,
                       const std::vector<std::string>& arguments)
    : patience_(patience()), process_(commandLine(job, folder, arguments), environmentIn(folder.string())) {}

void BlenderJob::fail(const std::string& problem) const {
  const std::string lines = process_.lastLines();
  throw Error(lines.empty() ? problem : fmt::format("{}; its last lines:\n{}", problem, lines));
}

BlenderAnswer BlenderJob::answer() {
  try {
    while (const std::optional<std::string> line = process_.readLine(patience_)) {
      const nlohmann::json fields = nlohmann::json::parse(*line, nullptr, false);
      if (!fields.is_object()) continue;  // Blender itself printed this line before the script started
      BlenderAnswer answer{fields.value("what", ""), fields.value("text", ""), fields.value("seconds", 0.0)};
      if (answer.kind == "error" && fields.value("input", false)) throw InputError(answer.text);
      return answer;
    }
    const std::string exitStatus = process_.wait(patience_);
    fail(fmt::format("Blender failed ({})", exitStatus));
  } catch (const TimeOut&) {
    fail(fmt::format("Blender did not finish within {} s: set SCANMILL_BLENDER_SECONDS to wait longer", patience_));
  } catch (const nlohmann::json::exception& e) {
    fail(fmt::format("the answer of Blender is not understood ({})", reasonOf(e)));
  }
}

const FormatSupport kBlenderFormat{
    "Blender, and what it imports", ".blend, .fbx, .abc, .x3d, .usd, .usda, .usdc, .usdz",
    "Surfaces of the active scene at its saved or first frame, of objects that both its viewport and its renders "
    "show, evaluated as in renders: modifiers, levels of subdivision, simplification, particles and other instances. "
    "Principled and other shaders, also mixed with a Transparent one: base colour and alpha (each a constant or an "
    "image placed by texture coordinates), roughness and metallic; slots of objects come before those of meshes. "
    "Images, packed or beside the file",
    "objects that the viewport or renders hide; objects of other scenes; edges, thin curves, hair, halos, point "
    "clouds, volumes and grease pencil; missing libraries, with all that is linked from them; opacities of materials "
    "whose blend mode is opaque; nodes of materials that are not read; animations (one frame counts); files that "
    "Inline of X3D names"};

std::filesystem::path exportByBlender(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::optional<BlenderJob> job;
  try {
    job.emplace("export", folder, std::vector<std::string>{std::filesystem::absolute(file).string()});
  } catch (const Error& e) {  // Blender cannot be started; the file may be sound
    throw Error("{}: {}", file.string(), e.what());
  }
  try {
    LeftOut leftOut;
    const auto counts = nlohmann::json::parse(job->answer().text).get<std::map<std::string, std::uint64_t>>();
    for (const auto& [content, count] : counts) leftOut.add(content, count);
    leftOut.warn(file.string());
    return folder / "scene.glb";
  } catch (const InputError& e) {
    throw InputError({file.string()}, e.what());
  } catch (const Error& e) {
    throw InputError({file.string()}, "cannot be read: {}", e.what());
  }
}

}  // namespace scanmill
