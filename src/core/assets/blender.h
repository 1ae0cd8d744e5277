#pragma once

// Runs scripts/blender_passes.py in the Blender that is installed.

#include <filesystem>
#include <string>
#include <vector>

#include "base/process.h"

namespace scanmill {

// The program that the environment variable SCANMILL_BLENDER names; without that, `blender` in PATH. Throws an Error
// that says how to install it.
std::filesystem::path blenderProgram();

struct BlenderAnswer {
  std::string what;  // "ready", "scene", "image" or "exported": see the script
  std::string text;
  double seconds = 0;  // since the request
};

// One run of the script. It cannot outlive the object. Blender starts from its factory settings, reads nothing that its
// user has configured, and runs no script of the files that it opens.
class BlenderJob {
 public:
  // `folder`, a temporary one for this run alone, must outlive the object; Blender's own temporary files go there too.
  // Throws Error where there is no Blender.
  BlenderJob(const std::string& job, const std::filesystem::path& folder, const std::vector<std::string>& arguments);

  // Sends a line to the script.
  void ask(const std::string& line);
  // Waits for the script's next answer, at most for the seconds that the environment variable SCANMILL_BLENDER_SECONDS
  // gives (600 without it). Throws an InputError, which does not name the file, where the user's file is at fault;
  // throws an Error with Blender's last lines where anything else fails.
  BlenderAnswer answer();

 private:
  [[noreturn]] void fail(const std::string& what) const;

  double patience_;  // s
  Process process_;
};

}  // namespace scanmill
