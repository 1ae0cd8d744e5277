#pragma once

// One scene with its sensors and its method, for scans from any pose.

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
  std::vector<Pose> worldFromSensor;  // one per step of the revolution
};

// Safe to use from several threads.
class Simulator {
 public:
  // `pipeline`: the text of a pipeline with one sequence; its relative paths start at `folder`. Throws InputError.
  Simulator(const std::string& pipeline, const std::filesystem::path& folder);

  // Returns one scan per sensor, as `scanmill generate` makes them with this pipeline if the vehicle is at this pose:
  // the same `frame` has the same noise. The vehicle stands still during the scan; objects of the scene are where they
  // are at `time` (s since the drive began).
  std::vector<SimulatedScan> scan(const Pose& worldFromVehicle, double time, std::uint32_t frame) const;

  const Plan& plan() const { return plan_; }
  const Scene& scene() const { return scene_; }

 private:
  Plan plan_;
  mutable ShotSource source_;  // safe to call from any thread
  Scene scene_;
  std::unique_ptr<Method> method_;
};

}  // namespace scanmill
