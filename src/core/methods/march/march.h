#pragma once

// Sphere tracing (Hart 1996): particles march from the sensor through a distance field. Each step is as long as the
// field says that the space around the particle is free. A particle ends where it meets a surface, where its way ends,
// or when its steps are used up.
//
// There are two backends: the lanes of the processor (march_stream.h) and a compute shader (march_shader.cpp). Both use
// float32 and nothing but additions, multiplications, comparisons and conversions, in the same order and without
// contraction. So both take the same steps, bit by bit, on any processor or GPU that keeps IEEE 754.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "methods/device/device_resolver.h"
#include "methods/field/distance_field.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "sensors/shot.h"

namespace scanmill {

enum class Outcome : std::uint32_t {
  Hit = 0,
  Miss = 1,       // the particle met nothing up to the end of its way
  Exhausted = 2,  // its steps were used up: neither a hit nor a miss
};

// Where the field has lists, particles go from voxel to voxel near surfaces and are intersected with the triangles
// there. Where it has none, a particle hits a surface where the interpolated distance (voxels of the level) is at most
// this. With half a voxel or more no plane is missed: a plane midway between two corners is half a voxel away from
// both.
constexpr float kRest = 0.501f;

// Particles before they march, as a structure of arrays, in the field frame: lengths in voxels of level 0.
struct Particles {
  std::vector<float> ox, oy, oz;  // origin, relative to the field's centre
  std::vector<float> dx, dy, dz;  // unit direction, world axes
  std::vector<float> begin, end;  // the part of the direction along which it marches; with begin >= end it misses
  // Only for fields with lists.
  std::vector<float> wx, wy, wz;  // m, origin relative to the world's origin
  std::vector<float> ix, iy, iz;  // 1 / direction; components smaller than 1e-12 count as 1e-12

  std::size_t size() const { return begin.size(); }
  void resize(std::size_t count, bool lists);
};

// What became of particles, in the same order.
struct HitRecords {
  std::vector<float> way;               // of a hit: the length marched, in the field frame
  std::vector<std::uint32_t> triangle;  // of a hit: index in World::baked
  std::vector<std::uint32_t> outcome;   // Outcome + 4 * steps taken

  std::size_t size() const { return way.size(); }
  void reset(std::size_t count);  // of particles that have taken no step
  Outcome outcomeOf(std::size_t i) const { return static_cast<Outcome>(outcome[i] & 3u); }
  std::uint32_t stepsOf(std::size_t i) const { return outcome[i] >> 2; }
  // Takes record `j` of others for record i.
  void copy(std::size_t i, const HitRecords& others, std::size_t j) {
    way[i] = others.way[j];
    triangle[i] = others.triangle[j];
    outcome[i] = others.outcome[j];
  }
};

// Marches the particles with the numbers `which` on the calling thread, as many at a time as the processor has lanes,
// until each has taken `steps` steps at most, those included that its record counts already. Alpha is not looked at
// here: every triangle is solid.
void marchCpu(const DistanceField& field, const TriangleBlock& triangles, std::uint32_t steps,
              const Particles& particles, std::span<const std::uint32_t> which, HitRecords& records);

// The particles of a shot: 16 columns of a ring after the other, ring after ring, then the next 16 columns. Those that
// the last columns lack do not march.
struct ParticleLaunch {
  static constexpr std::uint32_t kTogether = 16;  // columns
  const Shot* shot;
  const ShotFrame* frame;  // of the world's origin
  Box box;                 // m, relative to the world's origin: where particles may march
  double farthest;         // m, how far they go
  bool whole;              // nothing of the scene lies outside of the box
  bool corrected;          // without lists: to the plane of the triangle at which a particle rests
  std::size_t size() const {
    return std::size_t{shot->beams->rings} * ((shot->beams->columns + kTogether - 1) / kTogether) * kTogether;
  }
};

// Marches particles by a compute shader of OpenGL 4.3, one invocation a particle.
class GlMarcher {
 public:
  virtual ~GlMarcher() = default;
  // Launches the particles of a shot, marches them and fills the channels that `hits` has with what resolve() gives
  // (methods/particle/march_job.h); all of it on the device, bit by bit as the processor. Adds the rays that end as
  // neither hit nor miss, or that it leaves to the processor, ascending. While one thread waits for the device, or
  // copies what it has made, others may give it work, and shots in one field that wait for their turn fly together.
  // Adds to the stages "upload" (of field and scene), "march" (giving the device work, and waiting for it) and
  // "read_back". Throws Error, too, where the device's buffers do not hold the beams or the hits.
  virtual void march(std::shared_ptr<const DistanceField> field, std::shared_ptr<const World> world,
                     std::uint32_t steps, const ParticleLaunch& launch, Hits& hits,
                     std::vector<UndecidedRay>& undecided, StageClock& clock) = 0;
  virtual std::string device() const = 0;  // ComputeDevice::nameAndPlace()
};

// Throws Error where the machine has no OpenGL 4.3 by EGL: the text names the CPU backend.
std::unique_ptr<GlMarcher> makeGlMarcher();

}  // namespace scanmill
