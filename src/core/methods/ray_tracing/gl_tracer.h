#pragma once

// Ray tracing by compute shaders: hits of the rays of which rounding leaves no doubt.

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "methods/device/device_resolver.h"
#include "methods/ray_tracing/device_world.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

struct GlTracerLimits {
  // Of a table or buffer; the device's own limits hold too.
  std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
};

// Calls may come from any thread: while one waits for the device, or copies what it has made, others give it work; and
// shots that wait for their turn are traced together.
class GlTracer {
 public:
  // Throws Error where the machine has no OpenGL 4.3.
  explicit GlTracer(const GlTracerLimits& limits = {});
  ~GlTracer();
  GlTracer(const GlTracer&) = delete;
  GlTracer& operator=(const GlTracer&) = delete;

  // Fills the channels that `hits` has, one ray after the other, with what Embree with the tie rule (filter.h) and
  // methods/world/resolve.h would give, and adds the rays that it leaves to the processor, ascending. `farthest`: m,
  // how far rays go. Hierarchies, labels and textures stay on the device between calls, and so do beams. Adds to the
  // stages "trace" (giving the device work, and waiting for it) and "read_back". Throws Error where the scene does not
  // fit.
  void trace(const std::shared_ptr<const World>& world, const Shot& shot, const ShotFrame& frame, float farthest,
             float coplanar, Hits& hits, std::vector<UndecidedRay>& undecided, StageClock& clock);

  std::string device() const;            // ComputeDevice::nameAndPlace()
  std::uint64_t mostTableBytes() const;  // that a table may take there

 private:
  class Inside;
  std::unique_ptr<Inside> inside_;
};

constexpr std::uint32_t kNothingFound = 0xFFFFFFFFu;  // in the place of a triangle: the ray meets nothing
constexpr std::uint32_t kUnsureHit = 0xFFFFFFFEu;     // the shader cannot say: Embree must

// The compute programs; see gpu/compute.h. Storage buffers: 0 to 4 those of DeviceBeams, 5 what is found: the
// triangle's number in its block, kNothingFound or kUnsureHit of each ray, then 1 + its place in World::placed or 0 of
// each. Tables of the first: 0 nodes, 1 triangles, 2 cutouts, 3 holes of DeviceMeshes, 4 nodes and 5 places of
// DevicePlaces.
std::string traceShader();
// It makes hits of what is found: storage buffer 6 and tables are those of DeviceResolver.
std::string resolveShader();

}  // namespace scanmill
