#pragma once

// The compute programs of particles, assembled from the files in methods/gpu/shaders and the constants that the
// processor's code uses. A comment at the top of each file lists the program's buffers and tables. See gpu/compute.h.

#include <cstdint>
#include <string>
#include <string_view>

namespace scanmill {

constexpr float kLeftOut = -1;  // Particles::begin of a particle that is left to the processor

// Values that the outcome column of hit records can have besides those of Outcome.
constexpr std::uint32_t kGoOn = 3;                    // the particle continues behind a hole
constexpr std::uint32_t kParticleDone = 0x80000000u;  // flag: the particle's result is complete

// The text of rays.glsl alone, for programs that need the rays of shots.
extern const std::string_view kRaysShader;

// These functions return programs for fields with or without lists of triangles: the launch program creates particles,
// the march program takes their steps, and the last program computes hits from their records.
std::string launchShader(bool lists);
std::string marchShader(bool lists);
std::string particleHitsShader(bool lists);

}  // namespace scanmill
