#pragma once

// Sphere tracing (Hart 1996): particles fly from the sensor through a distance field, as far at a time as the field
// says is free, until they meet something.
//
// marchOne() in march_one.cpp is the rule; the backends do the same for many particles at once. They use float32 and
// nothing but additions, multiplications, comparisons and conversions, in the same order and without contraction, so
// that all of them take the same steps, bit by bit, on any processor or GPU that keeps IEEE 754.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "methods/field/field.h"
#include "methods/world/world.h"

namespace scanmill {

enum class Outcome : std::uint32_t {
  Hit = 0,
  Miss = 1,       // nothing up to the end of its way
  Exhausted = 2,  // out of steps: neither
  // Only without lists: it was at a brink, nearer than kBrink to a surface but nowhere at rest, and then moved away. It
  // has passed an edge, or gone through one: settleBrinks() tells which.
  Brink = 3,
};

struct MarchOptions {
  // Where a particle rests: so near to a surface, in voxels of the level, or cone * way where that is more; at most
  // kWidestHit. Not looked at where the field has lists.
  float hit = 0;
  float cone = 0;
  std::uint32_t steps = 0;  // at most so many
};

// Where the field has lists, particles go from voxel to voxel near surfaces and meet triangles exactly; else they rest
// where the interpolated distance is `hit`. Half a voxel is the least at which no plane is passed: midway between two
// corners both are half a voxel away.
constexpr float kRest = 0.501f;
constexpr float kWidestHit = 1.1f;

// Particles before their flight, a structure of arrays. Field frame: lengths in voxels of level 0.
struct Particles {
  std::vector<float> ox, oy, oz;  // origin, relative to the field's centre
  std::vector<float> dx, dy, dz;  // unit direction, world axes
  std::vector<float> begin, end;  // of its way along the direction; a particle with begin >= end misses
  // Only for fields with lists.
  std::vector<float> wx, wy, wz;  // m, origin relative to the world's origin
  std::vector<float> ix, iy, iz;  // 1 / direction; components smaller than 1e-12 count as 1e-12

  std::size_t size() const { return begin.size(); }
  void resize(std::size_t count, bool lists);
};

// Particles after it, in the same order.
struct Landings {
  std::vector<float> way;               // in the field frame; of a hit
  std::vector<std::uint32_t> triangle;  // of World::baked; of a hit
  std::vector<std::uint32_t> outcome;   // Outcome + 4 * steps taken

  std::size_t size() const { return way.size(); }
  void resize(std::size_t count);
  Outcome outcomeOf(std::size_t i) const { return static_cast<Outcome>(outcome[i] & 3u); }
  std::uint32_t stepsOf(std::size_t i) const { return outcome[i] >> 2; }
};

struct Landing {
  float way;
  std::uint32_t triangle;
  Outcome outcome;
  std::uint32_t steps;
};

// Flies particle i of `particles` alone: what the backends are tested against, and what goes on after a hit on
// something transparent. Alpha is not looked at here: every triangle is solid.
Landing marchOne(const Field& field, const TriangleBlock& triangles, const MarchOptions& options,
                 const Particles& particles, std::size_t i);

// Decides what became of the particles `at` brinks: a hit on what each has crossed or passed by at half a voxel or
// less, else it flies on. For fields without lists.
void settleBrinks(const Field& field, const TriangleBlock& triangles, const MarchOptions& options, Particles& particles,
                  std::span<const std::uint32_t> at, Landings& landings);

// What the field says of a place (field frame).
struct FieldPlace {
  float distance;          // voxels of the level: interpolated; at most the true one where the brick is empty
  std::uint32_t triangle;  // nearest to the corner nearest to the place; kNoWord: none near, or the field has lists
  double voxel;            // m, of the level
};

// The level that serves a place (field frame).
inline std::int32_t levelAt(const Field& field, float x, float y, float z) {
  const float most = std::max(std::fabs(x), std::max(std::fabs(y), std::fabs(z)));
  // The least l with most <= reach * 2^l, from the float's exponent.
  const float share = most * (1.0f / field.shape.reach);
  const auto exponent = static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(share) - 1u) >> 23;
  const auto last = static_cast<std::int32_t>(field.levels.size()) - 1;
  return share > 0 ? std::min(std::max(exponent - 126, 0), last) : 0;
}

// m, of that level.
double voxelAt(const Field& field, const Vec3f& place);

FieldPlace placeIn(const Field& field, const Vec3f& place);

// The first corner of the voxel around a place, in the arrays of bricks; kNoWord where the brick is empty.
std::uint32_t voxelCorner(const Field& field, const Vec3f& place);
// The corner nearest to a place, likewise.
std::uint32_t nearestCorner(const Field& field, const Vec3f& place);

// Flies particles [first, last) on the calling thread, 16 or 8 at a time.
void marchCpu(const Field& field, const TriangleBlock& triangles, const MarchOptions& options,
              const Particles& particles, std::size_t first, std::size_t last, Landings& landings);

// Flies them by a compute shader of OpenGL 4.3, one invocation a particle.
class GlMarcher {
 public:
  virtual ~GlMarcher() = default;
  // Flies all particles. `field` and `triangles` are uploaded where they are not those of the call before. Safe to call
  // from several threads: one waits for the other. Throws Error, also where the field is larger than the device's
  // buffers may be. Adds to the stages "upload" (of the field and the triangles), "march" (particles uploaded and
  // flown) and "read_back" (landings) of `clock`.
  virtual void march(std::shared_ptr<const Field> field, std::shared_ptr<const World> world,
                     const MarchOptions& options, const Particles& particles, Landings& landings,
                     StageClock& clock) = 0;
  virtual std::string device() const = 0;  // "llvmpipe (LLVM 15.0.6, 256 bits)"
  virtual bool software() const = 0;       // it runs on the processor
};

// Throws Error where the machine has no OpenGL 4.3 by EGL: the text names the CPU backend.
std::unique_ptr<GlMarcher> makeGlMarcher();

// Whether OpenGL 4.3 runs on more than the processor here. Does not throw; false where there is no OpenGL.
bool glHasHardware();

}  // namespace scanmill
