#include "pipeline/run/run_shot.h"

namespace scanmill {

ShotSetup setupOf(const Plan& plan, const Scene& scene, const Method& method, std::size_t sensor) {
  return {method, scene.materials, plan.channels(), plan.pipeline().effectsOf(sensor), plan.pipeline().layout};
}

TraceAccount runShot(const ShotSetup& setup, const Shot& shot, ShotBuffers& buffers, StageClock& clock) {
  TraceAccount account;
  {
    const StageTimer timer(clock, "trace");
    account = setup.method.trace(shot, setup.channels, buffers.hits);
  }
  const StageTimer timer(clock, "effects");
  senseShot(setup, shot, buffers.hits, buffers.returns, buffers.scan);
  return account;
}

void senseShot(const ShotSetup& setup, const Shot& shot, const Hits& hits, Returns& returns, Scan& scan) {
  sense(hits, shot, setup.effects, setup.materials, setup.layout, returns, scan);
}

}  // namespace scanmill
