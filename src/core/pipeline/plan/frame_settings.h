#pragma once

// How sensors stand in a frame and what their receivers make of hits: the same in all frames, unless the pipeline draws
// it at random.

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "config/distribution.h"
#include "pipeline/read/drawn_sensors.h"
#include "pipeline/read/pipeline.h"
#include "scan/hits.h"

namespace scanmill {

struct SensorSetting {
  Pose vehicleFromSensor;
  std::span<const std::unique_ptr<Effect>> effects;  // in the order in which they run
  const LightPaths* paths = nullptr;                 // null: rays end at what they meet first
  const Hits* vehicle = nullptr;                     // what its rays meet of the own vehicle; null: there is none
};

struct FrameSettings {
  std::vector<SensorSetting> sensors;

  // What they refer to, where it is not the pipeline's own, and what was drawn for that.
  SensorDraw drawn;
  std::shared_ptr<const std::vector<Hits>> vehicles;
};

using VehicleHits = std::shared_ptr<const std::vector<Hits>>;  // of each sensor; null: no vehicle

// As the pipeline says. The effects are the pipeline's own, which must outlive what is returned; it may be moved.
FrameSettings settingsOf(const Pipeline& pipeline, VehicleHits vehicles);

// Settings of a pipeline that draws some. Those of the sequences that were used last are kept. Safe to use from several
// threads.
class DrawnSettings {
 public:
  // `traceVehicles`: gives what the rays meet of the own vehicle with the sensors mounted so.
  template <class TraceVehicles>
  std::shared_ptr<const FrameSettings> of(const Pipeline& pipeline, std::size_t sequence, std::uint32_t frame,
                                          const VehicleHits& vehicles, const TraceVehicles& traceVehicles) {
    Kept kept = find(sequence);
    if (kept.whole != nullptr) return kept.whole;
    const DrawnSensors& sensors = *pipeline.drawn;
    SensorDraw drawn = sensors.draw(pipeline, sequence, frame);
    kept.sequence = sequence;
    if (kept.vehicles == nullptr) kept.vehicles = sensors.drawsMounts() ? traceVehicles(drawn.mounts) : vehicles;
    auto settings = std::make_shared<const FrameSettings>(joined(pipeline, std::move(drawn), kept.vehicles));
    if (!sensors.drawsPerFrame()) kept.whole = settings;
    keep(std::move(kept));
    return settings;
  }

 private:
  struct Kept {
    std::size_t sequence = 0;
    VehicleHits vehicles;
    std::shared_ptr<const FrameSettings> whole;  // null where frames differ
  };

  static FrameSettings joined(const Pipeline& pipeline, SensorDraw drawn, VehicleHits vehicles);
  Kept find(std::size_t sequence);
  void keep(Kept kept);

  std::mutex mutex_;
  std::list<Kept> kept_;  // those used last come first
};

}  // namespace scanmill
