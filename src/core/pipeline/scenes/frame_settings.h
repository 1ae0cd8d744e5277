#pragma once

// The mounts of the sensors and the effects of their receivers in a frame. They are the same in all frames, unless the
// pipeline gives random distributions for them. This header is installed because pipeline/scenes/shot_source.h includes
// it.
//
//   ShotSource source(plan);
//   const Pose vehicleFromSensor = source.settings().sensors.front().vehicleFromSensor;

#include <memory>
#include <vector>

#include "config/distribution.h"
#include "pipeline/read/pipeline.h"

namespace scanmill {

struct BlockedRays;

struct SensorSetting {
  Pose vehicleFromSensor;
  std::shared_ptr<const Effects> effects;
  // How rays continue behind a hit, from the effect light_paths; null: rays end at their first hit.
  const LightPaths* paths = nullptr;
  std::shared_ptr<const BlockedRays> vehicle;  // the rays that hit the ego vehicle; null: no ego vehicle
};

struct FrameSettings {
  std::vector<SensorSetting> sensors;
  std::vector<DrawnValue> draws;  // the random values in these settings
};

// The rays that hit the ego vehicle, by sensor; empty: no ego vehicle.
using VehicleHits = std::vector<std::shared_ptr<const BlockedRays>>;

// Returns the settings with the mounts and effects in Pipeline::sensors. `vehicles`: hits on the ego vehicle.
FrameSettings settingsOf(const Pipeline& pipeline, const VehicleHits& vehicles);

}  // namespace scanmill
