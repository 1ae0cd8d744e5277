#pragma once

// How sensors are mounted in a frame, and the effects of their receivers: the same in all frames, unless the pipeline
// gives random distributions for them.

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "config/distribution.h"
#include "pipeline/read/drawn_sensors.h"
#include "pipeline/read/pipeline.h"
#include "scan/hits.h"

namespace scanmill {

struct SensorSetting {
  Pose vehicleFromSensor;
  std::shared_ptr<const Effects> effects;
  const LightPaths* paths = nullptr;    // those of one of the effects; null: rays end at their first hit
  std::shared_ptr<const Hits> vehicle;  // hits of the sensor's rays on the own vehicle; null: no own vehicle
};

struct FrameSettings {
  std::vector<SensorSetting> sensors;
  std::vector<DrawnValue> draws;  // the random values in these settings
};

using VehicleHits = std::vector<std::shared_ptr<const Hits>>;  // one per sensor; empty: no own vehicle

// Returns the settings with the mounts and effects of Pipeline::sensors.
FrameSettings settingsOf(const Pipeline& pipeline, const VehicleHits& vehicles);

// Settings of a pipeline in which some are random. Caches those of the sequences that were used last. Safe to call from
// several threads.
class DrawnSettings {
 public:
  // Returns the settings of a frame. `first`: the result of settingsOf(). `traceVehicles`: returns the hits of the rays
  // on the own vehicle for given mounts of the sensors.
  template <class TraceVehicles>
  std::shared_ptr<const FrameSettings> of(const Pipeline& pipeline, std::size_t sequence, std::uint32_t frame,
                                          const FrameSettings& first, const TraceVehicles& traceVehicles) {
    Kept kept = find(sequence);
    if (kept.whole != nullptr) return kept.whole;
    const DrawnSensors& sensors = *pipeline.drawn;
    SensorDraw drawn = sensors.draw(pipeline, sequence, frame);
    kept.sequence = sequence;
    if (kept.vehicles == nullptr) {
      kept.vehicles =
          std::make_shared<const VehicleHits>(sensors.drawsMounts() ? traceVehicles(drawn.mounts) : vehiclesOf(first));
    }
    auto settings = std::make_shared<const FrameSettings>(joined(pipeline, std::move(drawn), *kept.vehicles));
    if (!sensors.drawsPerFrame()) kept.whole = settings;
    keep(std::move(kept));
    return settings;
  }

 private:
  struct Kept {
    std::size_t sequence = 0;
    std::shared_ptr<const VehicleHits> vehicles;
    std::shared_ptr<const FrameSettings> whole;  // null if frames differ
  };

  static VehicleHits vehiclesOf(const FrameSettings& settings);
  static FrameSettings joined(const Pipeline& pipeline, SensorDraw drawn, const VehicleHits& vehicles);
  Kept find(std::size_t sequence);
  void keep(Kept kept);

  std::mutex mutex_;
  std::list<Kept> kept_;  // the most recently used first
};

}  // namespace scanmill
