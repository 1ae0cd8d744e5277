#pragma once

// The compute programs of particles, assembled from the files in methods/gpu/shaders and the constants that the
// processor's code uses. Each file says on top which buffers and tables its program has. See gpu/compute.h.

#include <cstdint>
#include <string>
#include <string_view>

namespace scanmill {

constexpr float kLeftOut = -1;  // Particles::begin of a particle that is left to the processor

// Values that a hit record may have in place of an Outcome.
constexpr std::uint32_t kGoOn = 3;                    // the particle continues behind a hole
constexpr std::uint32_t kParticleDone = 0x80000000u;  // flag: the particle's hit has been made

// rays.glsl alone, for programs that need the rays of shots.
extern const std::string_view kRaysShader;

// Return the programs for fields with lists of triangles or without: one makes particles, one takes their steps, one
// turns their records into hits.
std::string launchShader(bool lists);
std::string marchShader(bool lists);
std::string particleHitsShader(bool lists);

}  // namespace scanmill
