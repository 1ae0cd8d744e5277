#pragma once

#include <cstdint>

#include "base/vec.h"
#include "config/fields.h"
#include "methods/field/distance_field.h"

namespace scanmill {

inline constexpr std::uint32_t kFewestVoxels = 64;              // least number of voxels across each level
inline constexpr std::uint32_t kVoxelsStep = 2 * kBrickVoxels;  // divides the number of voxels across each level

// The map `particle: {...}` of a pipeline.
struct ParticleOptions {
  enum class Backend { Cpu, Gl } backend = Backend::Cpu;  // on the CPU, or by compute shaders of OpenGL
  double voxel = 0.1;                                     // m, voxel size of the finest level
  std::uint32_t voxels = 256;                             // voxels across each level
  std::uint32_t levels = 0;                               // number of levels; 0: as many as the sensor's range needs
  enum class Refine { None, ByTriangle } refine = Refine::ByTriangle;
  std::uint32_t steps = 512;  // largest number of steps of a particle
  Location where;             // location of the key voxel_m or, if it is absent, of the map; for messages
};

// Reads {voxel_m: 0.1, voxels: 256, levels: auto, refine: triangle, steps: 512, backend: cpu}. Throws InputError.
ParticleOptions readParticleOptions(Fields& fields);

// Returns the shape of a field that reaches `range` (m) around a sensor at `sensor` (m, relative to the world's
// origin), but not farther than `scene` (the scene's bounds in the same frame; empty if the scene has no triangles).
// Depends only on its arguments. Throws Error, with advice, if the sensor is too far away for this voxel size.
FieldShape shapeOf(const ParticleOptions& options, const Vec3d& sensor, const Box& scene, double range);

// Returns approximately how many bytes a field takes. The number of non-empty bricks grows with the surface area, and
// hence with the square of `voxels`; the factor was measured on the procedural street.
double fieldBytes(const ParticleOptions& options);

// Throws InputError, with advice, if the estimated size of a field is more than twice `memory` (bytes). The limit is
// twice the memory because the estimate may be wrong by this factor.
void checkField(const ParticleOptions& options, double memory);

// Returns the box inside of which particles march: the box of the outermost level, shrunk by a voxel (m, relative to
// the world's origin).
Box marchBox(const FieldShape& shape);

}  // namespace scanmill
