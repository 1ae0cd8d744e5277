#pragma once

// One scene with its sensors and its method, for scans at any place.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/plan/plan.h"
#include "pipeline/run/run_shot.h"

namespace scanmill {

struct SimulatedScan {
  Scan scan;
  std::vector<Pose> worldFromSensor;  // one a step of the revolution
};

// Safe to use from several threads.
class Simulator {
 public:
  // The text of a pipeline with one sequence; relative names of files start at `folder`. Throws InputError.
  Simulator(const std::string& pipeline, const std::filesystem::path& folder);

  // One a sensor, as `scanmill generate` makes them of this pipeline where the vehicle is at this pose: the same frame
  // has the same noise. The vehicle stands still meanwhile; things of the scene are where they are at the time (s) from
  // where the drive began.
  std::vector<SimulatedScan> scan(const Pose& worldFromVehicle, double time, std::uint32_t frame) const;

  const Plan& plan() const { return plan_; }
  const Scene& scene() const { return scene_; }

 private:
  Plan plan_;
  mutable ShotSource source_;  // any thread may call it
  Scene scene_;
  std::unique_ptr<Method> method_;
};

}  // namespace scanmill
