#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "gpu/compute.h"
#include "methods/field/march_job.h"
#include "methods/gpu/device_beams.h"
#include "methods/gpu/device_march.h"
#include "methods/gpu/device_resolver.h"
#include "methods/gpu/shot_queue.h"
#include "scan/hits.h"

namespace scanmill {

// Limits of the work that is submitted at once. Tests set lower limits.
struct GlMarcherLimits {
  std::size_t particles = std::size_t{1} << 20;  // greatest number of particles that march at once
  ComputeLimits device = {};
};

// Marches particles by a compute shader of OpenGL, with one invocation per particle.
class GlMarcher {
 public:
  // Throws Error if the machine has no suitable device (gpu/compute.h); the message advises to use the CPU backend.
  explicit GlMarcher(const GlMarcherLimits& limits = {});

  // Launches the particles of a shot, marches them and fills the channels that `hits` has with the results of resolve()
  // (methods/particle/particles.h), all on the device and with the same bits as on the CPU. Appends the rays that
  // end as neither hit nor miss, or that are left to the CPU, to `unresolved`, in ascending order. While a thread waits
  // for the device or copies its results, other threads may submit work; waiting shots in the same field are dispatched
  // together. Adds to the stages "upload" (of field and scene), "march" (submitting the work and waiting for its
  // results) and "read_back" of `clock`. Throws Error, for instance if beams or hits do not fit into a device's buffer.
  void march(const MarchJob& job, Hits& hits, std::vector<UnresolvedRay>& unresolved, StageClock& clock);
  std::string device() const { return device_.name() + (device_.software() ? ", on the processor" : ""); }

 private:
  // The work on the particles of one shot, from launch to hits.
  struct ShotWork {
    const MarchJob& job;
    Channels channels;
    mutable double upload = 0;  // s, time to upload field and scene; only set in the first work of a dispatch

    std::size_t rays() const { return job.shot.beams->size(); }
    std::uint64_t bytes() const { return DeviceResolver::bytesPerRay(channels) * rays(); }
    bool canShareDispatch(const ShotWork& other) const;
  };
  using Queue = ShotQueue<ShotWork>;

  void dispatch(const std::vector<const ShotWork*>& together, Queue::Batch& batch);
  void marchSlice(const ShotWork& work, std::size_t rays, std::size_t first, std::size_t count);

  ComputeDevice device_;
  const std::uint64_t particlesAtOnce_;  // greatest number of particles that march at once
  MarchPrograms launchers_{device_, "launch", launchShader};
  MarchPrograms resolvers_{device_, "particles' hits", resolveShader};
  DeviceBeams beams_{device_};
  DeviceMarch march_{device_};
  DeviceResolver resolver_{device_};
  std::weak_ptr<const World> worldWithLabels_;  // the world whose planes and labels are uploaded
  Queue queue_{
      device_, device_.limits().bufferBytes,
      [this](const std::vector<const ShotWork*>& together, Queue::Batch& batch) { dispatch(together, batch); }};
};

}  // namespace scanmill
