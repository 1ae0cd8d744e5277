#pragma once

#include <cstdint>
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
