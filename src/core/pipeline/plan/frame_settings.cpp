#include "pipeline/plan/frame_settings.h"

#include <algorithm>
#include <utility>

#include "base/parallel.h"

namespace scanmill {

namespace {

const Hits* vehicleOf(const VehicleHits& vehicles, std::size_t sensor) {
  return vehicles == nullptr ? nullptr : &(*vehicles)[sensor];
}

}  // namespace

FrameSettings settingsOf(const Pipeline& pipeline, VehicleHits vehicles) {
  FrameSettings settings;
  settings.vehicles = std::move(vehicles);
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    settings.sensors.push_back({pipeline.sensors[s].vehicleFromSensor, pipeline.effectsOf(s), pipeline.lightPaths(s),
                                vehicleOf(settings.vehicles, s)});
  }
  return settings;
}

FrameSettings DrawnSettings::joined(const Pipeline& pipeline, SensorDraw drawn, VehicleHits vehicles) {
  FrameSettings settings;
  settings.drawn = std::move(drawn);
  settings.vehicles = std::move(vehicles);
  for (std::size_t s = 0; s < settings.drawn.mounts.size(); ++s) {
    const auto& effects = settings.drawn.effects[s].effects;
    const LightPaths* const paths = pipeline.recording == nullptr ? lightPaths(effects) : nullptr;
    settings.sensors.push_back({settings.drawn.mounts[s], effects, paths, vehicleOf(settings.vehicles, s)});
  }
  return settings;
}

DrawnSettings::Kept DrawnSettings::find(std::size_t sequence) {
  const std::scoped_lock lock(mutex_);
  const auto found =
      std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.sequence == sequence; });
  if (found == kept_.end()) return {};
  kept_.splice(kept_.begin(), kept_, found);
  return kept_.front();
}

void DrawnSettings::keep(Kept kept) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(kept_, [&](const Kept& known) { return known.sequence == kept.sequence; });
  kept_.push_front(std::move(kept));
  const auto most = 2 * static_cast<std::size_t>(threadCount());  // each makes samples of one sequence at a time
  if (kept_.size() > most) kept_.pop_back();
}

}  // namespace scanmill
