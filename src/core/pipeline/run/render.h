#pragma once

// Passes alone: what the depth-camera method draws of each shot, kept as a recording.

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
  PassChoice passes;
  bool overwrite = false;
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;  // as in GenerateOptions
};

struct RenderSummary {
  std::uint64_t shots = 0;
  std::uint64_t images = 0;
  std::uint64_t bytes = 0;
  double seconds = 0;
  std::map<std::string, double> stages;
  std::vector<std::string> warnings;
};

// Throws InputError where the pipeline's method draws no passes, Error where the work fails.
RenderSummary render(const Plan& plan, const RenderOptions& options);

}  // namespace scanmill
