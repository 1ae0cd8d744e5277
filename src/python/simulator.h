#pragma once

// The class Simulator holds a scene, its sensors and a simulation method, and makes scans from any pose.

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
  std::vector<Pose> worldFromSensor;  // sensor pose at each step of the revolution
};

// Makes scans of one scene. Safe to use from several threads.
class Simulator {
 public:
  // `pipeline`: text of a pipeline with one sequence. Relative paths in the text start at `folder`. Throws InputError.
  Simulator(const std::string& pipeline, const std::filesystem::path& folder);

  // Returns one scan per sensor, equal to those that `scanmill generate` makes with this pipeline for the frame number
  // `frame`, but with the vehicle at this pose. The frame number determines the noise. The vehicle stands still during
  // the scan; moving objects are at their positions at `time` (s since the drive began).
  std::vector<SimulatedScan> scan(const Pose& worldFromVehicle, double time, std::uint32_t frame) const;

  const Plan& plan() const { return plan_; }
  const Scene& scene() const { return scene_; }

 private:
  Plan plan_;
  mutable ShotSource source_;  // its functions may be called from any thread
  Scene scene_;
  std::unique_ptr<Method> method_;
};

}  // namespace scanmill
