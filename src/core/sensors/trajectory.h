#pragma once

// A trajectory: the pose of the vehicle as a function of time. It is defined by poses, a path with a speed, or a
// recording.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"
#include "scene/road_path.h"
#include "scene/scene.h"
#include "sensors/ground_profile.h"
#include "sensors/recorded_poses.h"

namespace scanmill {

class Fields;
class Path;

struct DriveStop {
  double position = 0;  // m along the path
  double duration = 0;  // s
};

class SpeedProfile {
 public:
  // A drive at a constant speed (m/s) along a path of length `length` (m).
  SpeedProfile(double length, double speed);
  // A drive that starts at rest at the path's start, stops at each of `stops` and ends at rest at the path's end. In
  // between it is as fast as these limits allow: `speed` (m/s), `acceleration` (m/s^2, also for braking), and the
  // lateral acceleration kSideways in bends. The stops are positions within the path, in ascending order.
  SpeedProfile(const Path& path, double speed, double acceleration, const std::vector<DriveStop>& stops);

  static constexpr double kSideways = 2;  // m/s^2, largest lateral acceleration in bends

  double duration() const { return nodes_.back().time; }  // duration of the drive (s)
  // Returns the distance driven (m) at a time (s); 0 before the start, the path's length after the end.
  double distance(double time) const { return stateAt(time).distance; }
  double speed(double time) const { return stateAt(time).speed; }  // returns the speed (m/s) at a time (s)
  // Returns the first time (s) at which the vehicle has driven `distance` (m, at most the path's length).
  double timeAt(double distance) const;

 private:
  // The state of the vehicle at a position on its path; between two nodes the acceleration is constant.
  struct Node {
    double time;      // s
    double distance;  // m along the path
    double speed;     // m/s
  };
  Node stateAt(double time) const;

  std::vector<Node> nodes_;  // ascending in time and distance
};

// Random roll, pitch and heave of a vehicle: sums of sinusoids of 0.6 to 2 Hz, the resonance frequencies of car bodies.
// A seed determines frequencies and phases. The sums are smooth and nearly normally distributed over time.
class Sway {
 public:
  Sway() = default;  // no sway
  // Reads {roll_deg: 0.5, pitch_deg: 0.3, heave_m: 0.01} from YAML: standard deviations while the vehicle drives at the
  // full speed of its drive. Throws InputError.
  Sway(const Value& value, std::uint64_t seed);

  // Returns the pose of the swaying vehicle in the frame of the vehicle without sway, at a time (s). The sway is
  // proportional to `speedFraction`, the vehicle's speed divided by the full speed.
  Pose at(double time, double speedFraction) const;

 private:
  static constexpr std::size_t kWaves = 10;
  struct Wave {
    double frequency = 0;  // rad/s
    double phase = 0;      // rad
  };
  using Waves = std::array<Wave, kWaves>;
  static double sum(const Waves& waves, double time);

  double roll_ = 0, pitch_ = 0;  // rad, standard deviations
  double heave_ = 0;             // m, standard deviation
  std::array<Waves, 3> waves_{};
};

// A drive on surfaces of certain classes, at random or from one point to another. Its path is computed after the scene
// is loaded.
struct RandomPath {
  std::vector<std::string> classes;
  RoadSide keep = RoadSide::Right;
  double length = 0;    // m, least length of the path
  double perFrame = 0;  // m, distance from frame to frame
  Location where = {};
  std::optional<RoadTrip> trip = {};  // none: the path is random
};

// The pose worldFromVehicle over time, from a map with one of the keys poses, waypoints, along, on and recorded;
// docs/keys.md explains all keys. See ground_profile.h for the ground, and recorded_poses.h for recordings.
class Trajectory {
 public:
  static constexpr std::uint32_t kMaxFrames = 10'000'000;

  std::uint32_t frames() const { return frames_; }  // number of frames
  // Returns the time of a frame's start (s since the start of the trajectory).
  double frameTime(std::uint32_t frame) const;
  // Returns the time from frame to frame (s). If the frames of an accelerating drive are equally spaced along the path,
  // this is the shortest of these times.
  double interval() const { return interval_; }
  // Returns true if the vehicle follows a path (false for listed poses) and its frames are equally far apart in time.
  bool regular() const { return !still() && everyMetres_ <= 0; }

  // Returns the pose `dt` seconds after the start of a frame. A vehicle with listed poses stands still in each frame; a
  // vehicle on a path stops at the path's end. Throws Error if the trajectory has no frame with this number.
  Pose pose(std::uint32_t frame, double dt) const;

  bool still() const { return !poses_.empty(); }  // true if the vehicle stands still in each frame
  const std::string& name() const { return name_; }
  // Returns how often a drive with `along: turns` turns off at a junction of its town; nullopt for other drives.
  std::optional<int> turns() const { return turns_; }
  // Returns a description of a recorded or random path for messages; empty for others.
  std::string about() const;
  // Returns a warning about recorded poses that are possible but probably wrong; otherwise empty.
  std::string warning() const { return recorded_ ? recorded_->warning() : std::string(); }

  // If randomPath() is not null, the trajectory has poses only after along(); if ground() is not null, the poses are on
  // the ground only after onGround().
  const RandomPath* randomPath() const { return random_ ? &*random_ : nullptr; }
  const GroundOptions* ground() const { return groundOptions_ ? &*groundOptions_ : nullptr; }
  // Returns a copy that follows a path of waypoints (m). The path must be at least as long as randomPath() requires.
  [[nodiscard]] Trajectory along(const std::vector<Vec3d>& waypoints) const;
  // Returns a copy placed on the ground. Throws InputError if a listed pose, or the whole path, has no ground under it.
  [[nodiscard]] Trajectory onGround(const Ground& ground) const;
  // Returns the fraction of the path without ground; 0 before onGround().
  double bareShare() const { return profileOfGround_ ? profileOfGround_->bareFraction() : 0; }
  // Returns the mean distance (m) of a path without the key `ground` from the ground, to which onGround() moves it if
  // ground() is not null afterwards; 0 before onGround().
  double clearanceByDefault() const { return clearanceByDefault_; }

 private:
  friend Trajectory readTrajectory(const Value& value, const std::string& name, double period, const SceneLanes* lanes,
                                   std::uint64_t seed, std::uint32_t drive);
  // Each of these functions reads one kind of trajectory. `period`: default time between frames (s). `limit`: the
  // largest number of frames, or infinity. readTrajectory() has set name_, lastTurn_ and groundOptions_ before.
  void readPoses(Fields& fields, double period, double limit);
  void readRecorded(Fields& fields, double period, double limit);
  void readDrive(Fields& fields, double period, double limit, std::uint64_t seed, const SceneLanes* lanes);
  // readRandomDrive() reads a drive with the key `on`, readPathDrive() a drive with waypoints or along lanes.
  void readRandomDrive(Fields& fields, double limit, const Location& where);
  void readPathDrive(Fields& fields, double limit, const SceneLanes* lanes);
  void readPath(Fields& fields, const SceneLanes* lanes);
  std::vector<Vec3d> levelled(std::vector<Vec3d> waypoints) const;
  void setPath(Path path);
  void setProfile();
  // Returns the vehicle's position on its path at a time (s): in m, or in s if the path was recorded.
  double positionAt(double time) const;
  // Returns the pose at a position on the path, before ground and sway are applied.
  Pose poseOnPath(double position) const;

  std::string name_;
  std::uint32_t frames_ = 0;
  double interval_ = 0;     // s, time from frame to frame
  double lastTurn_ = 0;     // s; the path must be known until this long after the last frame's start
  double everyMetres_ = 0;  // m, distance between frames, if the vehicle accelerates; 0: use interval_
  double speed_ = 0;        // m/s, largest speed along the path
  std::optional<int> turns_;
  std::vector<Pose> poses_;           // one per frame, in which the vehicle stands still; empty for paths
  std::shared_ptr<const Path> path_;  // path of a drive; null until it is known
  std::shared_ptr<const RecordedPoses> recorded_;
  std::optional<RandomPath> random_;
  double acceleration_ = 0;  // m/s^2; 0: constant speed
  std::vector<DriveStop> stops_;
  std::optional<SpeedProfile> profile_;
  Sway sway_;
  std::optional<GroundOptions> groundOptions_;
  std::shared_ptr<const GroundProfile> profileOfGround_;
  double clearanceByDefault_ = 0;  // m, see clearanceByDefault()
};

// Returns the number of trajectories that an item of the pipeline's list defines: the value of the key `drives` or, if
// the key is absent, 1. Throws InputError.
std::uint32_t countDrives(const Value& value);

// Reads a trajectory. `period`: longest duration of a sensor's revolution (s). This is the default time between frames,
// and the vehicle must continue for this time after the start of the last frame. `lanes`: the town's lanes that `along`
// refers to; null if the caller has no lanes. `seed`: seed of the vehicle's sway. `drive`: index of one of several
// random drives; the trajectory's name ends with it. Throws InputError.
Trajectory readTrajectory(const Value& value, const std::string& name, double period, const SceneLanes* lanes = nullptr,
                          std::uint64_t seed = 0, std::uint32_t drive = 0);

}  // namespace scanmill
