#pragma once

// Sphere tracing (Hart 1996): particles march from the sensor through a distance field. The length of each step is the
// distance around the particle that the field says is free. A particle ends where it hits a surface, at the end of its
// path, or after its largest number of steps.
//
// There are two backends: the SIMD lanes of the CPU (march_stream.h) and a compute shader
// (methods/gpu/shaders/march.glsl). Both use float32 and only additions, multiplications, comparisons and conversions,
// in the same order and without contraction to fused operations. Both therefore take the same steps, bit by bit, on any
// CPU or GPU that follows IEEE 754.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "methods/field/distance_field.h"
#include "methods/field/march_rule.h"
#include "methods/world/world.h"

namespace scanmill {

// Particles before they march, as a structure of arrays in the field frame: lengths are in voxels of level 0.
struct Particles {
  using Vectors = std::array<std::vector<float>, 3>;  // an array each of the components x, y and z
  Vectors origin;                                     // relative to the field's centre
  Vectors direction;                                  // unit vectors, world axes
  std::vector<float> begin, end;                      // limits of the marched section of the line; begin >= end: a miss
  // The following arrays are empty if the field has no lists.
  Vectors worldOrigin;  // m, the line's origin relative to the world's origin
  Vectors inverse;      // 1 / direction; a component with an absolute value below 1e-12 counts as 1e-12

  std::size_t size() const { return begin.size(); }
  void resize(std::size_t count, bool lists);
};

// The results of particles, in the order of the particles.
struct HitRecords {
  std::vector<float> travelled;         // distance from the particle's origin (field frame); set only for hits
  std::vector<std::uint32_t> triangle;  // index in World::baked; set only for hits
  std::vector<std::uint32_t> outcome;   // Outcome + 4 * number of steps

  std::size_t size() const { return travelled.size(); }
  void reset(std::size_t count);  // resets all records to zero steps
  Outcome outcomeOf(std::size_t i) const { return static_cast<Outcome>(outcome[i] & 3u); }
  std::uint32_t stepsOf(std::size_t i) const { return outcome[i] >> 2; }
};

// Marches the particles with the indices `which` on the calling thread, as many at a time as the CPU has vector lanes.
// Each particle takes at most `steps` steps, including the steps that its record already has. Alpha is ignored: every
// triangle is solid.
void marchCpu(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t steps,
              const Particles& particles, std::span<const std::uint32_t> which, HitRecords& records);

}  // namespace scanmill
