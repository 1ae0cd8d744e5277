#pragma once

// Loads the scenes of a plan and makes the shots of its frames, from what scenes and random values give.

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

// Makes the method that a pipeline or a study names; not `auto`, which names none. Throws InputError for what is wrong
// with the options.
std::unique_ptr<Method> makeMethod(const MethodChoice& choice, const Scene& scene);

struct Frame {
  std::shared_ptr<const FrameSettings> settings;
  std::vector<Shot> shots;  // one per sensor
};

// Any thread may call it at any time. It keeps the drives that it has found in scenes, and the settings that it has
// drawn for the sequences used last; neither changes a result.
class ShotSource {
 public:
  // Reads the own vehicle and traces it. The plan must outlive what is made. Throws InputError.
  explicit ShotSource(const Plan& plan);
  ShotSource(const ShotSource&) = delete;
  ShotSource& operator=(const ShotSource&) = delete;

  const Plan& plan() const { return plan_; }

  // Loads the scene of a sequence; textures only where a channel needs them. Of a recording: what scans need of its
  // scene, which is its classes and materials. Throws InputError.
  Scene load(std::size_t sequence);
  std::unique_ptr<Method> method(const Scene& scene) const;

  // Returns the drive of a sequence, with the way and on the ground that it has in its scene, which is loaded unless
  // load() has done so; not of a recording.
  std::shared_ptr<const Trajectory> drive(std::size_t sequence);

  // Returns the settings of the first frame of the first sequence; where nothing is drawn at random, those of all.
  const FrameSettings& settings() const { return *settings_; }
  // Returns how the sensors stand in a frame and what runs on their scans. Throws InputError where what is drawn at
  // random cannot be.
  std::shared_ptr<const FrameSettings> settings(std::size_t sequence, std::uint32_t frame);
  // Returns the settings and the shots of a frame. Throws InputError as settings() and drive() do.
  Frame frame(std::size_t sequence, std::uint32_t number);

  // Of each sensor, as it is mounted in the first frame: the share of its rays that the own vehicle is in the way of.
  // Empty where there is no vehicle.
  std::vector<double> blockedShares() const;

 private:
  Scene recordedScene(std::size_t sequence) const;
  Shot recordedShot(const std::string& sample, std::uint32_t frame, std::size_t sensor) const;
  VehicleHits traceOwnVehicle(const std::vector<Pose>& mounts) const;
  void findDrives(const Sequence& sequence, const Scene& scene);

  const Plan& plan_;
  const Pipeline& pipeline_;
  std::shared_ptr<const Scene> vehicle_;           // null: no own vehicle
  std::shared_ptr<const FrameSettings> settings_;  // of the first frame of the first sequence
  DrawnSettings drawn_;
  std::mutex mutex_;                                                 // of what follows
  std::map<std::size_t, std::shared_ptr<const Trajectory>> drives_;  // that follow from scenes, by sequence
};

}  // namespace scanmill
