#pragma once

// Renders the passes of all shots with the depth-camera method and saves them as a recording, without making scans.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "passes/pass_image.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

struct RenderOptions {
  std::filesystem::path folder;
  PassChoice passes{};
  bool overwrite = false;
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;  // may be null; once it is true, rendering stops with an Error
};

struct RenderSummary {
  std::uint64_t shots = 0;
  std::uint64_t images = 0;
  std::uint64_t bytes = 0;
  double seconds = 0;
  std::map<std::string, double> stages;
  std::vector<std::string> warnings;
};

// Renders and records the passes of all frames. Throws InputError if the pipeline's method renders no passes, and Error
// if the work fails.
RenderSummary render(const Plan& plan, const RenderOptions& options);

}  // namespace scanmill
