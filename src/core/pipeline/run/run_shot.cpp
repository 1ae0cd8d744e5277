#include "pipeline/run/run_shot.h"

#include <optional>

namespace scanmill {

ShotSetup setupOf(const Plan& plan, const FrameSettings& settings, const Scene& scene, const Method& method,
                  std::size_t sensor) {
  const SensorSetting& setting = settings.sensors[sensor];
  ScanLayout layout = plan.pipeline.output.layout;
  layout.columns = plan.columns();
  return {.method = method,
          .channels = plan.channels,
          .receiver = {*setting.effects, scene.materials, layout},
          .footprint = plan.sensors[sensor].footprint.get(),
          .vehicle = setting.vehicle.get(),
          .paths = setting.paths,
          .moving = InstanceMotions::areNeeded(scene, layout) ? &scene : nullptr};
}

TraceAccount traceShot(const ShotSetup& setup, const Shot& shot, Hits& hits) {
  Shot rays = shot;
  if (setup.footprint != nullptr) rays.beams = beamsAt(setup.footprint->rays, shot.time);
  const BlockedRays* vehicle = setup.vehicle;
  BlockedRays revolutionVehicle;
  if (vehicle != nullptr && vehicle->ofRevolution) {
    revolutionVehicle = vehicle->ofRevolution(*rays.beams);
    vehicle = &revolutionVehicle;
  }
  if (vehicle != nullptr) rays.blockedBeyond = vehicle->range;
  TraceAccount account = setup.method.trace(rays, setup.channels, hits);
  if (vehicle != nullptr) blockByVehicle(*vehicle, shot.beams->minRange, hits);
  if (setup.footprint != nullptr) joinRays(*setup.footprint, hits);
  if (setup.paths != nullptr) account += followLight(setup.method, rays, setup.receiver.materials, *setup.paths, hits);
  return account;
}

TraceAccount runShot(const ShotSetup& setup, const Shot& shot, ShotBuffers& buffers, StageClock& clock) {
  TraceAccount account;
  {
    const StageTimer timer(clock, "trace");
    account = traceShot(setup, shot, buffers.hits);
  }
  const StageTimer timer(clock, "effects");
  senseShot(setup, shot, buffers.hits, buffers.returns, buffers.scan);
  return account;
}

void senseShot(const ShotSetup& setup, const Shot& shot, const Hits& hits, Returns& returns, Scan& scan) {
  std::optional<InstanceMotions> motions;
  if (setup.moving != nullptr) motions.emplace(*setup.moving, shot);
  Receiver receiver = setup.receiver;
  receiver.motions = motions ? &*motions : nullptr;
  sense(receiver, hits, shot, returns, scan);
}

}  // namespace scanmill
