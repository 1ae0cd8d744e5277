#pragma once

// Runs scripts/blender_passes.py in the installed Blender, for images and for files that Blender opens (.blend) or
// imports (.fbx, .abc, .x3d, .usd).

#include <filesystem>
#include <string>
#include <vector>

#include "base/format_support.h"
#include "base/process.h"

namespace scanmill {

// Returns the program that the environment variable SCANMILL_BLENDER names; without the variable, `blender` in PATH. If
// there is no such program, throws an Error that says how to install Blender.
std::filesystem::path blenderProgram();

struct BlenderAnswer {
  std::string kind;  // "ready", "scene", "image" or "exported" (see the script)
  std::string text;
  double seconds = 0;  // s since the request
};

// A running script. The destructor ends it. Blender starts with its factory settings, ignores the user's configuration,
// and runs no script of the files that it opens.
class BlenderJob {
 public:
  // Starts the script. `folder` is a temporary folder of this run only, which must outlive the object; Blender writes
  // its temporary files there. Throws Error if Blender is not installed.
  BlenderJob(const std::string& job, const std::filesystem::path& folder, const std::vector<std::string>& arguments);

  // Sends a line to the script.
  void ask(const std::string& line) { process_.write(line + "\n"); }
  // Waits for the script's next answer, at most the number of seconds in the environment variable
  // SCANMILL_BLENDER_SECONDS (600 by default). Throws an InputError, which does not name the file, if the user's file
  // is at fault; throws an Error with Blender's last lines if anything else fails.
  BlenderAnswer answer();

 private:
  // Throws an Error with the problem and, if there are any, the last lines that Blender printed.
  [[noreturn]] void fail(const std::string& problem) const;

  double patience_;  // s, longest wait for an answer
  Process process_;
};

// States what is read from files that Blender opens or imports, and what is left out.
extern const FormatSupport kBlenderFormat;

// Converts the visible contents of a file, as kBlenderFormat says, to a GLB in a folder, and returns the GLB's path.
// Names stay the same, but Blender adds .001 to a name that occurs twice. Coordinates are converted to metres and z up,
// by the unit and axes of the file. The GLB names missing images by their paths. Warns of what is left out. Throws an
// InputError that names the file if it is damaged or of another kind, was saved by a newer Blender, or shows nothing,
// or if this Blender has no importer for it. Throws Error if Blender is not installed.
std::filesystem::path exportByBlender(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace scanmill
