#include "python/simulator.h"

#include <memory>
#include <utility>

#include "base/error.h"

namespace scanmill {

namespace {

Pipeline pipelineOf(const std::string& text, const std::filesystem::path& folder) {
  Pipeline pipeline = readPipelineText(text, folder / "simulation.yaml");
  if (pipeline.sequences.size() != 1)
    throw InputError("a simulation must have one scene with one seed and one trajectory");
  if (pipeline.method.automatic) throw InputError("a simulation needs a method by its name, not `auto`");
  return pipeline;
}

}  // namespace

Simulator::Simulator(const std::string& pipeline, const std::filesystem::path& folder)
    : plan_(makePlan(pipelineOf(pipeline, folder))),
      source_(plan_),
      scene_(source_.load(0)),
      method_(source_.method(scene_)) {
  plan_.checkMemory(method_->memoryBytes(), "the scene");
}

std::vector<SimulatedScan> Simulator::scan(const Pose& worldFromVehicle, double time, std::uint32_t frame) const {
  std::vector<SimulatedScan> scans;
  const std::shared_ptr<const FrameSettings> settings = source_.settings(0, frame);
  for (Shot& shot : source_.frame(0, 0).shots) {
    shot.frame = frame;
    shot.time = time;
    shot.beams = beamsAt(plan_.sensors[shot.sensor].beams, time);
    shot.worldFromSensor = {worldFromVehicle * settings->sensors[shot.sensor].vehicleFromSensor};
    ShotBuffers buffers;
    StageClock clock({"trace", "effects"});
    runShot(setupOf(plan_, *settings, scene_, *method_, shot.sensor), shot, buffers, clock);
    scans.push_back({std::move(buffers.scan), std::move(shot.worldFromSensor)});
  }
  return scans;
}

}  // namespace scanmill
