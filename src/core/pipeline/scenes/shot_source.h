#pragma once

// Loads the scenes of a plan and makes the shots of its frames.
//
//   ShotSource source(plan);
//   const Scene first = source.load(0);             // the scene of the first sequence
//   const Frame frame = source.frame(0, 12);        // a shot for each sensor
//   source.method(first)->trace(frame.shots.front(), plan.channels, hits);

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "methods/method.h"
#include "pipeline/plan/plan.h"
#include "pipeline/scenes/frame_settings.h"
#include "scene/scene.h"
#include "sensors/shot.h"
#include "sensors/trajectory.h"

namespace scanmill {

// Creates the method that a pipeline or a study names; `auto` must have been settled before. Throws InputError for
// wrong options, and if the scene moves and the method cannot follow it.
std::unique_ptr<Method> makeMethod(const MethodChoice& choice, const Scene& scene);

struct Frame {
  std::shared_ptr<const FrameSettings> settings;
  std::vector<Shot> shots;  // one per sensor
};

// Safe to call from several threads. Caches the drives that it has found in scenes, and the random settings of the
// sequences used last; neither cache changes a result.
class ShotSource {
 public:
  // Reads the own vehicle and traces it. The plan must outlive this object. Throws InputError.
  explicit ShotSource(const Plan& plan);
  explicit ShotSource(Plan&&) = delete;
  ShotSource(const ShotSource&) = delete;
  ShotSource& operator=(const ShotSource&) = delete;

  const Plan& plan() const { return plan_; }

  // Loads the scene of a sequence, with textures only if a channel needs them. For a recording, the scene has only the
  // classes and materials, which are all that scans need. Throws InputError.
  Scene load(std::size_t sequence);
  std::unique_ptr<Method> method(const Scene& scene) const;

  // Returns the trajectory of a sequence, with its random path and on the ground if it asks for them. Loads the scene
  // if they depend on it and load() was not called yet. Not for recordings, which have no trajectories.
  std::shared_ptr<const Trajectory> drive(std::size_t sequence);

  // Returns the settings of the first frame of the first sequence; if nothing is random, they are those of all frames.
  const FrameSettings& settings() const { return *settings_; }
  // Returns the mounts and effects of the sensors in a frame. Throws InputError if random values do not fit together.
  std::shared_ptr<const FrameSettings> settings(std::size_t sequence, std::uint32_t frame);
  // Returns the settings and the shots of a frame. Throws InputError as settings() and drive() do.
  Frame frame(std::size_t sequence, std::uint32_t number);

  // Returns for each sensor, as it is mounted in the first frame, the share of its rays that the own vehicle blocks;
  // an empty list without an own vehicle.
  std::vector<double> blockedShares() const;

 private:
  Scene recordedScene(std::size_t sequence) const;
  Shot recordedShot(const std::string& sample, std::uint32_t frame, std::size_t sensor) const;
  VehicleHits traceOwnVehicle(const std::vector<Pose>& mounts) const;
  void findDrives(const Sequence& sequence, const Scene& scene);

  const Plan& plan_;
  const Pipeline& pipeline_;
  std::shared_ptr<const Scene> vehicle_;           // null: no own vehicle
  std::shared_ptr<const FrameSettings> settings_;  // the settings of the first frame of the first sequence
  DrawnSettings drawn_;
  std::mutex mutex_;                                                 // guards drives_
  std::map<std::size_t, std::shared_ptr<const Trajectory>> drives_;  // those found in scenes, by sequence
};

}  // namespace scanmill
