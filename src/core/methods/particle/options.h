#pragma once

#include <cstdint>
#include <string>

#include "base/vec.h"
#include "config/fields.h"
#include "methods/field/distance_field.h"

namespace scanmill {

inline constexpr std::uint32_t kFewestVoxels = 64;              // least number of voxels across each level
inline constexpr std::uint32_t kVoxelsStep = 2 * kBrickVoxels;  // divides the number of voxels across each level

// The map `particle: {...}` of a pipeline.
struct ParticleOptions {
  enum class Backend { Cpu, Gl } backend = Backend::Cpu;  // on the processor, or by compute shaders of OpenGL
  double voxel = 0.1;                                     // m, voxel size of the finest level
  std::uint32_t voxels = 256;                             // voxels across each level
  std::uint32_t levels = 0;                               // number of levels; 0: as many as the sensor's range needs
  enum class Refine { None, ByTriangle } refine = Refine::ByTriangle;
  std::uint32_t steps = 512;  // largest number of steps of a particle
  Location where;             // location of the key voxel_m or, if it is absent, of the map; for messages
};

// {voxel_m: 0.1, voxels: 256, levels: auto, refine: triangle, steps: 512, backend: cpu}
//
// Throws InputError.
ParticleOptions readParticleOptions(Fields& fields);

// Returns the distance up to which a level of a field is used (m from the field's centre, along each
// axis): FieldShape::reach * voxel * 2^level. The level's bricks reach voxels / 2 from the centre of their box, which
// may be half a brick away from the field's centre; one voxel is a margin.
double levelReach(const ParticleOptions& options, std::uint32_t level);

// Returns approximately how many bytes a level with `voxels` voxels across takes. The number of non-empty bricks grows
// with the surface area, and hence with the square of `voxels`; the factor was measured on the procedural street.
double levelBytes(double voxels, bool lists);

// Returns a number of bytes as text, such as "1.2 GiB" or "34 MiB".
std::string memoryText(double bytes);

// Returns the diameter (m) of the smallest ball at `range` m from the sensor that is hit by every beam through its
// centre; infinite beyond the last level.
//
// With `refine: none` the diameter is two voxels, because one step may take a particle through both sides of a thinner
// object. Of beams through the centre, 0.8 % miss a ball of half a voxel, 0.4 % miss a ball of
// 1.25 voxels, and none of 30,000 misses a ball of 1.8 voxels or more.
//
// With `refine: triangle` the diameter is 0: every triangle is in full bricks, and is intersected exactly.
double smallestSeen(const ParticleOptions& options, double range);

// Returns the shape of a field that reaches `range` (m) around a sensor at `sensor` (m, relative to the world's
// origin), but not farther than `scene` (the scene's bounds in the same frame; empty if the scene has no triangles).
// Depends only on its arguments. Throws InputError, with advice, if the field would have too many bricks.
FieldShape shapeOf(const ParticleOptions& options, const Vec3d& sensor, const Box& scene, double range);

// Returns approximately how many bytes a field takes.
double fieldBytes(const ParticleOptions& options);

// Throws InputError, with advice, if the estimated size of a field is more than twice `memory` (bytes). The limit is
// twice the memory because the estimate may be wrong by this factor.
void checkField(const ParticleOptions& options, double memory);

// Returns the box inside of which particles march: the box of the outermost level, shrunk by a voxel (m, relative to
// the world's origin).
Box marchBox(const FieldShape& shape);

}  // namespace scanmill
