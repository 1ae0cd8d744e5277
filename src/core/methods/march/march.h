#pragma once

// Sphere tracing (Hart 1996): particles march from the sensor through a distance field. Each step is as long as the
// field says that the space around the particle is free. A particle ends where it meets a surface, where its way ends,
// or when its steps are used up.
//
// marchOne() in march_one.cpp defines the steps for one particle; the backends take the same steps for many particles
// at once. All use float32 and nothing but additions, multiplications, comparisons and conversions, in the same order
// and without contraction. So all backends take the same steps, bit by bit, on any processor or GPU that keeps IEEE
// 754.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "methods/field/distance_field.h"
#include "methods/world/world.h"

namespace scanmill {

enum class Outcome : std::uint32_t {
  Hit = 0,
  Miss = 1,       // the particle met nothing up to the end of its way
  Exhausted = 2,  // its steps were used up: neither a hit nor a miss
  // A candidate for a grazing hit, only for fields without lists. The particle came nearer than kGrazing to a surface,
  // but not near enough for a hit, and then moved away from it. It has passed by an edge or gone through the surface
  // there: settleGrazing() decides.
  Grazing = 3,
};

struct MarchOptions {
  // A particle hits a surface that is this near, in voxels of the level, or as near as cone * way where that is more;
  // at most kWidestHit. Only used where the field has no lists.
  float hit = 0;
  float cone = 0;
  std::uint32_t steps = 0;  // that a particle may take
};

// Where the field has lists, particles go from voxel to voxel near surfaces and are intersected with the triangles
// there. Where it has none, a particle hits a surface where the interpolated distance is at most MarchOptions::hit.
// With half a voxel or more no plane is missed: a plane midway between two corners is half a voxel away from both.
constexpr float kRest = 0.501f;
constexpr float kWidestHit = 1.1f;

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
  void resize(std::size_t count);
  Outcome outcomeOf(std::size_t i) const { return static_cast<Outcome>(outcome[i] & 3u); }
  std::uint32_t stepsOf(std::size_t i) const { return outcome[i] >> 2; }
};

struct HitRecord {
  float way;
  std::uint32_t triangle;
  Outcome outcome;
  std::uint32_t steps;
};

// Marches particle i of `particles` alone. The backends are tested against it, and particles that have met something
// transparent go on by it. Alpha is not looked at here: every triangle is solid.
HitRecord marchOne(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
                   const Particles& particles, std::size_t i);

// Decides the candidates for grazing hits among the particles with the numbers `at`, for fields without lists. A
// candidate hits the triangle that its line has crossed near there, or else the nearest one at half a voxel or less;
// where there is neither, it marches on until its outcome is another.
void settleGrazing(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
                   Particles& particles, std::span<const std::uint32_t> at, HitRecords& records);

// What the field holds at a place (field frame).
struct FieldPlace {
  float distance;  // interpolated, voxels of the level; in an empty brick a lower bound
  // The triangle nearest to the corner that is nearest to the place; kNoWord where none is near or the field has lists.
  std::uint32_t triangle;
  double voxel;  // m, of the level
};

// The level that serves a place (field frame).
inline std::int32_t levelAt(const DistanceField& field, float x, float y, float z) {
  const float most = std::max(std::fabs(x), std::max(std::fabs(y), std::fabs(z)));
  // The least l with most <= reach * 2^l, from the float's exponent.
  const float share = most * (1.0f / field.shape.reach);
  const auto exponent = static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(share) - 1u) >> 23;
  const auto last = static_cast<std::int32_t>(field.levels.size()) - 1;
  return share > 0 ? std::min(std::max(exponent - 126, 0), last) : 0;
}

// m, of that level.
double voxelAt(const DistanceField& field, const Vec3f& place);

FieldPlace placeIn(const DistanceField& field, const Vec3f& place);

// The first corner of the voxel around a place, in the arrays of bricks; kNoWord where the brick is empty.
std::uint32_t voxelCorner(const DistanceField& field, const Vec3f& place);
// The corner nearest to a place, likewise.
std::uint32_t nearestCorner(const DistanceField& field, const Vec3f& place);

// Marches particles [first, last) on the calling thread, as many at a time as the processor has lanes.
void marchCpu(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
              const Particles& particles, std::size_t first, std::size_t last, HitRecords& records);

// Marches particles by a compute shader of OpenGL 4.3, one invocation a particle.
class GlMarcher {
 public:
  virtual ~GlMarcher() = default;
  // Marches all particles. `field` and `triangles` are uploaded where they are not those of the call before. Safe to
  // call from several threads: one waits for the other. Throws Error, also where the field is larger than the device's
  // buffers may be. Adds to the stages "upload" (of the field and the triangles), "march" (particles uploaded and
  // flown) and "read_back" (hit records) of `clock`.
  virtual void march(std::shared_ptr<const DistanceField> field, std::shared_ptr<const World> world,
                     const MarchOptions& options, const Particles& particles, HitRecords& records,
                     StageClock& clock) = 0;
  virtual std::string device() const = 0;  // "llvmpipe (LLVM 15.0.6, 256 bits)"
  virtual bool software() const = 0;       // it runs on the processor
};

// Throws Error where the machine has no OpenGL 4.3 by EGL: the text names the CPU backend.
std::unique_ptr<GlMarcher> makeGlMarcher();

// Whether OpenGL 4.3 runs on more than the processor here. Does not throw; false where there is no OpenGL.
bool glHasHardware();

}  // namespace scanmill
