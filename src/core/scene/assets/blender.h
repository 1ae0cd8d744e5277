#pragma once

// Blender at work for us: scripts/blender_passes.py, run by the Blender that is installed.

#include <filesystem>
#include <string>
#include <vector>

#include "base/process.h"

namespace scanmill {

// The program: SCANMILL_BLENDER, or `blender` in PATH. Throws Error that says how to install it.
std::filesystem::path blenderProgram();

struct BlenderAnswer {
  std::string what;  // "ready", "scene", "image", "exported"; see the script
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

  void ask(const std::string& line);
  // The next answer, for at most SCANMILL_BLENDER_SECONDS (600). Throws InputError where the user's file is at fault,
  // without its name, and Error with Blender's last lines.
  BlenderAnswer answer();

 private:
  [[noreturn]] void fail(const std::string& what) const;

  double patience_;  // s
  Process process_;
};

}  // namespace scanmill
