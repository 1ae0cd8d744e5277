#pragma once

// How sensors stand in a frame and what their receivers make of hits: the same in all frames, unless the pipeline draws
// it at random.

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
  const LightPaths* paths = nullptr;    // those of one of the effects; null: rays end at what they meet first
  std::shared_ptr<const Hits> vehicle;  // what its rays meet of the own vehicle; null: there is none
};

struct FrameSettings {
  std::vector<SensorSetting> sensors;
  std::vector<DrawnValue> draws;  // what was drawn at random for them
};

using VehicleHits = std::vector<std::shared_ptr<const Hits>>;  // of each sensor; empty: no vehicle

// Returns the settings as the pipeline says them.
FrameSettings settingsOf(const Pipeline& pipeline, const VehicleHits& vehicles);

// Settings of a pipeline that draws some at random. Those of the sequences that were used last are kept. Any thread may
// call it at any time.
class DrawnSettings {
 public:
  // `first`: the settings as the pipeline says them. `traceVehicles`: gives what the rays meet of the own vehicle with
  // the sensors mounted so.
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
    std::shared_ptr<const FrameSettings> whole;  // null where frames differ
  };

  static VehicleHits vehiclesOf(const FrameSettings& settings);
  static FrameSettings joined(const Pipeline& pipeline, SensorDraw drawn, const VehicleHits& vehicles);
  Kept find(std::size_t sequence);
  void keep(Kept kept);

  std::mutex mutex_;
  std::list<Kept> kept_;  // those used last come first
};

}  // namespace scanmill
