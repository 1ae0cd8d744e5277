#pragma once

// A beam becomes a hit in three steps: launch() makes Particles, marchCpu() marches the particles and writes
// HitRecords, and resolve() turns the records into Hits. A device does the same by the shaders launch.glsl,
// march_*.glsl and resolve_*.glsl in methods/gpu/shaders.
//
// The march is sphere tracing (Hart 1996): particles march from the sensor through a distance field. The length of each
// step is the radius around the particle in which the field has no surface. A particle ends where it hits a surface, at
// the end of its path, or after its largest number of steps. The SIMD lanes of the CPU (march_stream.h) and the shaders
// use float32 and only additions, multiplications, comparisons and conversions, in the same order and without fused
// operations. Both therefore take the same steps, bit by bit, on any CPU or GPU that follows IEEE 754.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "methods/field/march_job.h"
#include "methods/field/march_rule.h"
#include "methods/world/resolve.h"
#include "scan/hits.h"

namespace scanmill {

// Particles before they march, as a structure of arrays in the field frame: lengths are in voxels of level 0.
struct Particles {
  using Vectors = std::array<std::vector<float>, 3>;  // one array for each of the components x, y, z
  Vectors origin;                                     // relative to the field's centre
  Vectors direction;                                  // unit vectors, world axes
  std::vector<float> begin, end;                      // limits of the marched section of the line; begin >= end: a miss
  // The following arrays are empty if the field has no lists.
  Vectors worldOrigin;  // m, the line's origin relative to the world's origin
  Vectors inverse;      // 1 / direction; a component with an absolute value below 1e-12 counts as 1e-12

  std::size_t size() const { return begin.size(); }
  void resize(std::size_t count, bool lists) {
    for (std::size_t k = 0; k < 3; ++k) {
      origin[k].resize(count);
      direction[k].resize(count);
      worldOrigin[k].resize(lists ? count : 0);
      inverse[k].resize(lists ? count : 0);
    }
    begin.resize(count);
    end.resize(count);
  }
};

// Sets `particles` to kPacket particles per tile, in the order of the tiles. Particles without a beam are misses.
void launch(const MarchJob& job, std::span<const Tile> tiles, Particles& particles);

// The results of particles, in the order of the particles.
struct HitRecords {
  std::vector<float> travelled;         // distance from the particle's origin (field frame); set only for hits
  std::vector<std::uint32_t> triangle;  // index in World::baked; set only for hits
  std::vector<std::uint32_t> outcome;   // Outcome + 4 * number of steps

  std::size_t size() const { return travelled.size(); }
  // Makes `count` records, all with zero steps.
  void reset(std::size_t count) {
    travelled.assign(count, 0);
    triangle.assign(count, 0);
    outcome.assign(count, 0);
  }
  Outcome outcomeOf(std::size_t i) const { return static_cast<Outcome>(outcome[i] & 3u); }
  std::uint32_t stepsOf(std::size_t i) const { return outcome[i] >> 2; }
};

// Marches the particles `indices` on the calling thread, as many at a time as the CPU has vector lanes, and sets their
// records. A particle takes at most `maxSteps` steps, including the steps already in its record. Alpha is ignored.
void marchCpu(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t maxSteps,
              const Particles& particles, std::span<const std::uint32_t> indices, HitRecords& records);

// The section of each lane's beam that is inside of the job's box (m along the beam).
struct Sections {
  alignas(64) Lane begin, end;
};
Sections sectionsInsideBox(const MarchJob& job, const Rays& rays);

// Numbers of beams that are neither hit nor miss, or whose hit is unreliable.
struct UnreliableBeams {
  std::uint64_t exhausted = 0;  // beams whose particles used up all their steps
  std::uint64_t leftField = 0;  // beams whose particles left the field, which does not cover the complete scene
  std::uint64_t touching = 0;   // beams whose particles started so near to a surface that they hit it at once

  void add(const UnreliableBeams& other) {
    exhausted += other.exhausted;
    leftField += other.leftField;
    touching += other.touching;
  }
};

// Computes hits from the records of marched particles: lets particles pass transparent triangles (in fields with
// lists), fills the channels that `hits` has, and appends the beams that are neither hits nor misses to `unresolved`.
// `particles`, `records`: kPacket per tile, in the order of tiles. Returns the numbers of unreliable beams.
UnreliableBeams resolve(const MarchJob& job, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                        Particles& particles, HitRecords& records, Hits& hits, std::vector<std::uint32_t>& unresolved);

}  // namespace scanmill
