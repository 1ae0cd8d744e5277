#include "pipeline/scenes/frame_settings.h"

#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "pipeline/scenes/drawn_settings.h"

namespace scanmill {

namespace {

std::shared_ptr<const BlockedRays> vehicleOf(const VehicleHits& vehicles, std::size_t sensor) {
  return vehicles.empty() ? nullptr : vehicles[sensor];
}

}  // namespace

FrameSettings settingsOf(const Pipeline& pipeline, const VehicleHits& vehicles) {
  FrameSettings settings;
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    const MountedSensor& sensor = pipeline.sensors[s];
    settings.sensors.push_back(
        {sensor.vehicleFromSensor, sensor.effects, pipeline.lightPaths(s), vehicleOf(vehicles, s)});
  }
  return settings;
}

VehicleHits DrawnSettings::vehiclesOf(const FrameSettings& settings) {
  VehicleHits vehicles;
  for (const SensorSetting& sensor : settings.sensors) vehicles.push_back(sensor.vehicle);
  return vehicles;
}

FrameSettings DrawnSettings::joined(const Pipeline& pipeline, SensorDraw drawn, const VehicleHits& vehicles) {
  FrameSettings settings;
  settings.draws = std::move(drawn.draws);
  for (std::size_t s = 0; s < drawn.mounts.size(); ++s) {
    const LightPaths* const paths = pipeline.recording == nullptr ? lightPaths(*drawn.effects[s]) : nullptr;
    settings.sensors.push_back({drawn.mounts[s], drawn.effects[s], paths, vehicleOf(vehicles, s)});
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
  // Two cached sequences per thread are enough, since each thread makes samples of one sequence at a time.
  const auto most = 2 * static_cast<std::size_t>(threadCount());
  if (kept_.size() > most) kept_.pop_back();
}

}  // namespace scanmill
