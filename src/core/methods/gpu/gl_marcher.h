#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "methods/field/distance_field.h"
#include "methods/field/particle_launch.h"
#include "methods/gpu/device_resolver.h"
#include "methods/world/world.h"
#include "scan/hits.h"

namespace scanmill {

// Marches particles by a compute shader of OpenGL 4.3, with one invocation per particle.
class GlMarcher {
 public:
  virtual ~GlMarcher() = default;
  // Launches the particles of a shot, marches them and fills the channels that `hits` has with the results of resolve()
  // (methods/particle/march_job.h), all on the device and with the same bits as on the processor. Adds the rays that
  // end as neither hit nor miss, or that are left to the processor, to `undecided`, ascending. While one thread waits
  // for the device or copies its results, other threads may submit work; waiting shots in the same field are dispatched
  // together. Adds to the stages "upload" (of field and scene), "march" (submitting the work and waiting for its
  // results) and "read_back" of `clock`. Throws Error, for instance if the beams or the hits do not fit into the
  // device's buffers.
  virtual void march(std::shared_ptr<const DistanceField> field, std::shared_ptr<const World> world,
                     std::uint32_t steps, const ParticleLaunch& launch, Hits& hits,
                     std::vector<UndecidedRay>& undecided, StageClock& clock) = 0;
  virtual std::string device() const = 0;  // returns the result of ComputeDevice::nameAndPlace()
};

// Limits of the work that is submitted at once. Tests set lower limits.
struct GlMarcherLimits {
  std::size_t particles = std::size_t{1} << 20;  // greatest number of particles that march at once
  // Largest size of a table (bytes); the limit of the device applies too.
  std::uint64_t tableBytes = std::numeric_limits<std::uint64_t>::max();
};

// Throws Error if the machine has no OpenGL 4.3 through EGL; the message names the CPU backend.
std::unique_ptr<GlMarcher> makeGlMarcher(const GlMarcherLimits& limits = {});

}  // namespace scanmill
