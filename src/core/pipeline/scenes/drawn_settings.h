#pragma once

// Samples the mounts and effects of the sensors for pipelines in which some mounts or effects are random.

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <utility>

#include "pipeline/read/drawn_sensors.h"
#include "pipeline/scenes/frame_settings.h"

namespace scanmill {

// The settings of a pipeline with random mounts or effects. Caches the settings of the most recently used sequences.
// Safe to call from several threads.
class DrawnSettings {
 public:
  // Returns the settings of a frame. `first`: the result of settingsOf(). traceVehicles(mounts) returns the sensors'
  // hits on the ego vehicle for these mounts.
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
    // Settings of all frames of the sequence; null if frames have different settings.
    std::shared_ptr<const FrameSettings> whole;
  };

  static VehicleHits vehiclesOf(const FrameSettings& settings);
  static FrameSettings joined(const Pipeline& pipeline, SensorDraw drawn, const VehicleHits& vehicles);
  Kept find(std::size_t sequence);
  void keep(Kept kept);

  std::mutex mutex_;
  std::list<Kept> kept_;  // settings of sequences, the most recently used first
};

}  // namespace scanmill
