#pragma once

// Loads the scenes of a plan and makes the shots of its frames.
//
//   ShotSource source(plan);
//   const Scene first = source.load(0);             // the scene of the first sequence
//   const Frame frame = source.frame(0, 12);        // a shot for each sensor
//   source.method(first)->trace(frame.shots.front(), plan.channels, hits);

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/recently_used.h"
#include "base/vec.h"
#include "config/distribution.h"
#include "methods/interface/method.h"
#include "methods/method.h"
#include "pipeline/plan/plan.h"
#include "scan/hits.h"
#include "scene/builder.h"
#include "scene/scene.h"
#include "sensors/beams.h"
#include "sensors/shot.h"

namespace scanmill {

class Trajectory;

// The rays of a sensor that hit the vehicle which carries the sensor. They are the same for all shots, since sensor and
// vehicle move together, unless the sensor's beams differ from revolution to revolution.
struct BlockedRays {
  bool dropped = false;                // true: these rays give no return
  std::vector<float> range;            // m, by ray of the sensor; kMiss: the ray does not hit the vehicle
  std::vector<std::uint32_t> blocked;  // indices of the rays that hit it, ascending
  Hits hits;                           // the hits of these rays, in the same order

  // Traces the beams of another revolution; null if the sensor's beams are the same in all revolutions.
  std::function<BlockedRays(const BeamTable& beams)> ofRevolution{};

  // Returns the fraction of the rays that hit the vehicle.
  double share() const { return static_cast<double>(blocked.size()) / static_cast<double>(range.size()); }
};

// For each ray that hits the vehicle before anything else, replaces the hit or miss by the hit on the vehicle, with
// path EgoVehicle, no instance, no material and a matt surface. If this hit is nearer than the sensor's minimum range
// `minRange` (m), or if `vehicle.dropped` is true, it becomes a miss with path EgoVehicle. `vehicle` and `hits` must
// have the same rays.
void blockByVehicle(const BlockedRays& vehicle, double minRange, Hits& hits);

struct SensorSetting {
  Pose vehicleFromSensor;
  bool scans = true;  // false: another sensor of the random choice scans
  std::shared_ptr<const Effects> effects;
  // How rays continue behind a hit, from the effect light_paths; null: rays end at their first hit.
  const LightPaths* paths = nullptr;
  std::shared_ptr<const BlockedRays> vehicle;  // the rays that hit the ego vehicle; null: no ego vehicle
};

// The mounts of the sensors and the effects of their receivers in a frame. They are the same in all frames, unless the
// pipeline gives random distributions for them.
struct FrameSettings {
  std::vector<SensorSetting> sensors;
  std::vector<DrawnValue> draws;  // the random values in these settings
};

// The rays that hit the ego vehicle, by sensor; empty: no ego vehicle.
using VehicleHits = std::vector<std::shared_ptr<const BlockedRays>>;

// Creates the method that a pipeline or a study names. Throws InputError for wrong options, and if the scene has moving
// objects that the method cannot trace.
std::unique_ptr<Method> makeMethod(const MethodChoice& choice, const Scene& scene);
// Returns a method that does not trace: it returns the recorded hits of the pipeline's recording, or samples its
// recorded passes. The pipeline must outlive the method.
std::unique_ptr<Method> makeRecordedMethod(const Pipeline& pipeline);

// Changes that a program makes to the scenes that it loads.
struct SceneChanges {
  std::function<void(SceneBuilder&)> add = nullptr;  // adds objects: see SceneOptions::add
  bool placeable = false;                            // see Scene::placeable
};

// The revolutions of each sensor that get a shot in a frame: only the revolution that begins with the frame, or all
// revolutions in the dataset's sample (see Sequence::revolutions()).
enum class Revolutions { First, All };

struct Frame {
  std::shared_ptr<const FrameSettings> settings;
  std::uint32_t number = 0;  // index of the frame in the sequence
  double time = 0;           // s since the start of the sequence
  std::vector<Shot> shots;
};

// Makes the shots of a plan's frames. Caches the trajectories that depend on scenes, and the random settings of the
// most recently used sequences; the caches do not change results. Safe to call from several threads.
class ShotSource {
 public:
  // Reads the ego vehicle, if there is one, and traces each sensor's rays to it. The plan must outlive this object.
  // Throws InputError.
  explicit ShotSource(const Plan& plan, SceneChanges changes = {});
  explicit ShotSource(Plan&&, SceneChanges = {}) = delete;

  const Plan& plan() const { return plan_; }

  // Loads the scene of a sequence; textures only if a channel needs them. For a recording, the scene has only classes
  // and materials, which are all that scans need. Throws InputError.
  Scene load(std::size_t sequence);
  std::unique_ptr<Method> method(const Scene& scene) const;
  // Returns the ego vehicle, in its own frame; null if there is none.
  std::shared_ptr<const Scene> vehicle() const { return vehicle_; }

  // Returns the trajectory of a sequence, on its random path and on the ground if the trajectory asks for these. If the
  // trajectory needs the scene and load() has not been called for the sequence, loads the scene. Must not be called for
  // recordings, which have no trajectories.
  std::shared_ptr<const Trajectory> trajectory(std::size_t sequence);

  // Returns the mounts and effects of the sensors in the first frame of the first sequence. If nothing is random, they
  // apply to all frames.
  const FrameSettings& settings() const { return *settings_; }
  // Returns the mounts and effects of the sensors in a frame. Throws InputError for an invalid combination of random
  // values.
  std::shared_ptr<const FrameSettings> settings(std::size_t sequence, std::uint32_t frame);
  // Returns the settings and the shots of a frame, in the order of the sensors. Throws InputError for the same reasons
  // as settings() and trajectory().
  Frame frame(std::size_t sequence, std::uint32_t number, Revolutions revolutions = Revolutions::First);

  // Returns for each sensor the fraction of its rays that hit the ego vehicle, with the mounts of the first frame and
  // the beams of the first revolution. Empty if there is no ego vehicle.
  std::vector<double> blockedShares() const;
  // Returns the files that the ego vehicle was read from.
  const std::vector<FileRecord>& vehicleFiles() const { return vehicleFiles_; }

 private:
  Scene recordedScene(std::size_t sequence) const;
  Shot recordedShot(const std::string& sample, std::uint32_t frame, std::size_t sensor) const;
  VehicleHits traceEgoVehicle(const std::vector<Pose>& mounts) const;
  void findTrajectories(const Sequence& sequence, const Scene& scene);

  const Plan& plan_;
  const Pipeline& pipeline_;
  SceneChanges changes_;
  std::shared_ptr<const Scene> vehicle_;  // null: no ego vehicle
  std::vector<FileRecord> vehicleFiles_;
  VehicleHits vehicleHits_;                        // with the mounts of the first frame of the first sequence
  std::shared_ptr<const FrameSettings> settings_;  // settings of that frame
  std::mutex mutex_;                               // guards the members below
  // Settings of the last used frame of each sequence with random mounts or effects, with the sequence's index.
  RecentlyUsed<std::pair<std::size_t, std::shared_ptr<const FrameSettings>>> drawn_;
  // Trajectories that depend on scenes, by index of their sequence.
  std::map<std::size_t, std::shared_ptr<const Trajectory>> trajectories_;
};

}  // namespace scanmill
