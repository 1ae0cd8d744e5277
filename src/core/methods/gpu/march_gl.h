#pragma once

// Internals of GlMarcher: its programs, and limits of the work that it submits at once. Tests set lower limits.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "gpu/compute.h"
#include "methods/gpu/gl_marcher.h"
#include "methods/gpu/shaders.h"

namespace scanmill {

struct GlMarcherLimits {
  std::size_t particles = std::size_t{1} << 20;  // greatest number of particles that march at once
  // Largest size of a table (bytes); the limit of the device applies too.
  std::uint64_t tableBytes = std::numeric_limits<std::uint64_t>::max();
};

// A program of shaders.h in two variants, for fields without lists and with lists, each compiled when it is first
// needed.
class MarchPrograms {
 public:
  MarchPrograms(const ComputeDevice& device, const char* name, std::string (*shader)(bool lists))
      : device_(device), name_(name), shader_(shader) {}
  ComputeProgram& of(bool lists) {
    std::unique_ptr<ComputeProgram>& program = programs_[lists ? 1 : 0];
    if (program == nullptr) program = std::make_unique<ComputeProgram>(device_, name_, shader_(lists));
    return *program;
  }

 private:
  ComputeDevice device_;
  const char* name_;
  std::string (*shader_)(bool lists);
  std::array<std::unique_ptr<ComputeProgram>, 2> programs_;
};

std::unique_ptr<GlMarcher> makeGlMarcher(const GlMarcherLimits& limits);

}  // namespace scanmill
