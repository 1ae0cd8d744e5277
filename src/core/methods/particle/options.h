#pragma once

#include <cstdint>
#include <string>

#include "config/fields.h"
#include "methods/field/distance_field.h"

namespace scanmill {

inline constexpr double kLargestVoxel = 10;                     // m, limit of ParticleOptions::voxel
inline constexpr std::uint32_t kFewestVoxels = 64;              // across each level
inline constexpr std::uint32_t kVoxelsStep = 2 * kBrickVoxels;  // whole bricks on both sides of the centre

// The map `particle: {...}` of a pipeline.
struct ParticleOptions {
  enum class Backend { Cpu, Gl } backend = Backend::Cpu;        // the processor, or compute shaders of OpenGL
  enum class Extent { Sensor, Scene } extent = Extent::Sensor;  // levels around the sensor, or one level for all
  double voxel = 0.1;                                           // m, of the finest level
  std::uint32_t voxels = 256;                                   // across each level
  std::uint32_t levels = 0;                                     // 0: as many as the sensor's range takes
  enum class Refine { None, ByNormal, ByTriangle } refine = Refine::ByTriangle;
  std::uint32_t steps = 512;  // most steps of a particle
  Location where;             // the key that chose the voxels, for messages
};

// {field: sensor, voxel_m: 0.1, voxels: 256, levels: auto, refine: triangle, steps: 512, backend: cpu}
//
// Throws InputError, also for a key that has no effect in combination with the others.
ParticleOptions readParticleOptions(Fields& fields);

// Returns how far a level of a field around a sensor serves: m from the field's centre along each axis,
// FieldShape::reach * voxel * 2^level. The level's bricks reach voxels / 2 from the middle of their box, which is up to
// half a brick off the field's centre; one voxel is a margin.
double levelReach(const ParticleOptions& options, std::uint32_t level);

// Returns about how many bytes a level with `voxels` voxels across takes. Memory grows with the surface area, hence
// with the square of the voxels; the factor was measured on the procedural street.
double levelBytes(double voxels, bool lists);

// Returns an estimate as text: 1.2 GiB, 34 MiB.
std::string memoryText(double bytes);

// Returns the diameter (m) of the smallest ball at `range` m from the sensor that every beam through its middle hits;
// infinite beyond the last level.
//
// With `refine: none` and `normal` the diameter is two voxels. Of the beams through the middle of a ball 0.8 % miss a
// ball of half a voxel, 0.4 % one of 1.25 voxels, and none of 30,000 one of 1.8 voxels or more: one step may take a
// particle through both sides of a thinner object.
//
// With `refine: triangle` the size does not matter: every triangle lies in full bricks, and is intersected exactly.
double smallestSeen(const ParticleOptions& options, double range);

}  // namespace scanmill
