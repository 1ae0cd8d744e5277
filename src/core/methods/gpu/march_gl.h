#pragma once

// Internals of GlMarcher: its shaders, and limits on how much it gives its device at once, which tests set lower.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "gpu/compute.h"
#include "methods/gpu/gl_marcher.h"

namespace scanmill {

struct GlMarcherLimits {
  std::size_t particles = std::size_t{1} << 20;  // that march at once
  // Most bytes of a table; the limit of the device applies too.
  std::uint64_t tableBytes = std::numeric_limits<std::uint64_t>::max();
};

// Returns the compute program that takes the steps of march_stream.h, for fields with lists or without; see
// gpu/compute.h.
//
// Storage buffers: 0 particles (float columns, in the order of Particles), 1 hit records (uint columns: bits of the
// way, triangle, outcome; with lists also the bits of a numerator and a denominator, whose quotient (m) is still to be
// added to the way). Tables: 0 the field's levels (two uvec4 each: bits of the offset and the first entry, then the
// bricks), 1 its table, 2 distances, 3 words, 4 lists, 5 triangles (three vec4 each: a corner and the two edges from
// it; m, relative to the world's origin). Parameters: MarchBlock of device_march.cpp.
std::string marchShader(bool lists);

// Returns the compute program that makes the particles of ParticleLaunch. Storage buffers: 0 to 3 those of DeviceBeams,
// 4 particles as above. Parameters: LaunchBlock of march_gl.cpp.
std::string launchShader(bool lists);

constexpr float kLeftOut = -1;  // Particles::begin of a particle that is left to the processor

// Values that a hit record may have in place of an Outcome.
constexpr std::uint32_t kGoOn = 3;                    // the particle continues behind a hole
constexpr std::uint32_t kParticleDone = 0x80000000u;  // flag: the particle's hit has been made

// Returns the compute program that turns the records of particles into hits, for fields with lists or without. Storage
// buffers: 0 to 3 those of DeviceBeams, 4 hit records and 6 particles as above, 5 and tables 0 to 3 those of
// DeviceResolver. Tables without lists: 4 the field's levels, 5 its table, 6 distances, 7 words. Parameters: HitsBlock
// of march_gl.cpp.
std::string particleHitsShader(bool lists);

// One of these programs in two variants, for fields without lists and with lists, each compiled when it is first
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
