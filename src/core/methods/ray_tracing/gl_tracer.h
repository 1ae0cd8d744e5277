#pragma once

// Ray tracing by a compute shader: finds the triangles that rays meet first, where rounding leaves no doubt of them.

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "methods/ray_tracing/device_world.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "sensors/shot.h"

namespace scanmill {

constexpr std::uint32_t kNothingFound = 0xFFFFFFFFu;  // in the place of a triangle: the ray meets nothing
constexpr std::uint32_t kUnsureHit = 0xFFFFFFFEu;     // the shader cannot say: Embree must

// What the rays of a shot meet, ring * columns + column.
struct FoundTriangles {
  std::vector<std::uint32_t> triangle;  // number in its block, kNothingFound or kUnsureHit
  std::vector<std::uint32_t> place;     // 1 + index into World::placed; 0: the baked block

  void resize(std::size_t rays);
};

struct GlTracerLimits {
  // Of a table or buffer; the device's own limits hold too.
  std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
};

// Calls may come from any thread.
class GlTracer {
 public:
  // Throws Error where the machine has no OpenGL 4.3.
  explicit GlTracer(const GlTracerLimits& limits = {});
  ~GlTracer();
  GlTracer(const GlTracer&) = delete;
  GlTracer& operator=(const GlTracer&) = delete;

  // Of a triangle that `found` names, Embree with the tie rule (filter.h) would have found the same, and the distance
  // to its plane is that to the triangle (intersectPlanes() in methods/world/resolve.h). `farthest`: m, how far rays
  // go. Hierarchies stay on the device between calls, and so do beams. Adds "upload", "trace" and "read_back" to the
  // clock. Throws Error where the scene does not fit.
  void trace(const std::shared_ptr<const World>& world, const Shot& shot, const ShotFrame& frame, float farthest,
             float coplanar, FoundTriangles& found, StageClock& clock);

  std::string device() const;

 private:
  class Inside;
  std::unique_ptr<Inside> inside_;
};

// The compute program; see gpu/compute.h. Storage buffers: 0 directions, 1 origins, 2 firing times, 3 poses, 4 the
// step of each column, 5 what is found (columns of FoundTriangles). Tables: 0 nodes, 1 triangles, 2 cutouts, 3 holes of
// DeviceMeshes, 4 nodes and 5 places of DevicePlaces.
std::string traceShader();

}  // namespace scanmill
