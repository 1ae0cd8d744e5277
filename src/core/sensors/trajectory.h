#pragma once

// A trajectory: where the vehicle is at each time. It is given by single poses, or by waypoints driven at a speed.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"
#include "scene/lanes.h"
#include "sensors/ground_profile.h"
#include "sensors/recorded_poses.h"
#include "sensors/speed_profile.h"
#include "sensors/sway.h"

namespace scanmill {

class Fields;
class Path;

// A drive on surfaces of certain classes of the scene, whose way is found when the scene is known.
struct RandomWay {
  enum class Side { Right, Left, Middle };
  std::vector<std::string> classes;
  Side keep = Side::Right;
  double length = 0;  // m, at least so long
  Location where;
};

// The pose worldFromVehicle over time. In YAML it has one of poses, waypoints, along, on and recorded:
//
//   poses: [{position: [x, y, z], yaw_deg: 90}, ...]        # one frame each; the vehicle stands still in each
//   waypoints: [[x, y, z], ...]                             # driven at `speed` (m/s), heading along the path
//   path: spline | line                                     # through the waypoints; see base/path.h
//   rounding: 0.5                                           # m, of the corners of `path: line`
//   along: lane                                             # in place of waypoints: those of the caller; or turns
//   on: [road]                                              # likewise: a random drive on surfaces of these classes
//   keep: right | left | middle                             # of them
//   drives: 3                                               # so many random drives, each a sequence: name-0, ...
//   recorded: {file: poses.txt, ...}                        # likewise: see recorded_poses.h
//   speed: 8.0
//   acceleration: 1.5                                       # m/s^2: from rest to rest, slower in bends; see
//                                                           # speed_profile.h
//   stops: [{at: 60, wait: 4}]                              # m along the way, s; needs acceleration
//   lane_changes: [{at: 80, left: 3, over: 30}]             # m along the way, m to the left by the end of so many m
//   sway: {roll_deg: 0.4, pitch_deg: 0.3, heave_m: 0.01}    # see sway.h
//   ground: drop                                            # see ground_profile.h
//   every_s: 0.1 | every_m: 1.0                             # a frame each (poses: every_s only, the time between two)
//   frames: 40                                              # optional limit; waypoints end the path where absent
//   name: loop                                              # optional
class Trajectory {
 public:
  static constexpr std::uint32_t kMaxFrames = 10'000'000;

  std::uint32_t frames() const { return frames_; }  // how many there are
  // The time of a frame's start (s since the start of the trajectory).
  double frameTime(std::uint32_t frame) const;

  // The pose `dt` seconds after the start of a frame. A vehicle with listed poses stands still in each frame; one on a
  // path drives to the end of it and stops there. Throws Error for a frame that there is not.
  Pose pose(std::uint32_t frame, double dt) const;

  bool still() const { return !poses_.empty(); }  // the vehicle stands still in each frame
  double pathLength() const;                      // m; 0 for listed poses
  const std::string& name() const { return name_; }
  // Of a drive along the turns of a town: how many there are.
  std::optional<int> turns() const { return turns_; }
  // What its way is, in words; empty where there is nothing to say.
  std::string about() const;
  // What is legal but seldom meant of recorded poses, in words; else empty.
  std::string doubt() const { return recorded_ ? recorded_->doubt() : std::string(); }

  // What it asks of the scene before it has poses; null where it asks for nothing.
  const RandomWay* randomWay() const { return random_ ? &*random_ : nullptr; }
  const GroundOptions* ground() const { return ground_ ? &*ground_ : nullptr; }
  // Itself along this way (m), which must be as long as randomWay() asks for.
  Trajectory along(const std::vector<Vec3d>& way) const;
  // Itself on the ground. Throws InputError where there is none.
  Trajectory onGround(const Ground& ground) const;
  // The share of the way that has no ground, after onGround().
  double bareShare() const { return profileOfGround_ ? profileOfGround_->bare() : 0; }

 private:
  friend Trajectory readTrajectory(const Value& value, const std::string& name, double fallbackPeriod,
                                   const SceneLanes* lanes, std::uint64_t seed, std::uint32_t drive,
                                   double longestTurn);
  struct LaneChange {
    double at, left, over;  // m
  };
  static std::vector<LaneChange> readLaneChanges(const Value& value, double length);
  void readPoses(Fields& fields, double fallbackPeriod, double limit);
  void readRecorded(Fields& fields, double fallbackPeriod, double limit);
  void readDrive(Fields& fields, double fallbackPeriod, double limit, std::uint64_t seed, const SceneLanes* lanes);
  void readWay(Fields& fields, const SceneLanes* lanes);
  std::vector<Vec3d> overGround(std::vector<Vec3d> way) const;
  void setPath(Path path);
  void setProfile();
  // Where the vehicle is on its way at a time: in m, or in s where it was recorded.
  double placeAt(double time) const;
  // The pose there, without ground and sway.
  Pose poseOnWay(double place) const;

  std::string name_;
  std::uint32_t frames_ = 0;
  double interval_ = 0;     // s, from frame to frame
  double lastTurn_ = 0;     // s after the start of the last frame, for which the way must be known
  double everyMetres_ = 0;  // of a vehicle that accelerates, in place of that; 0: none
  double speed_ = 0;        // m/s
  std::optional<int> turns_;
  std::vector<Pose> poses_;           // one per frame where the vehicle stands still
  std::shared_ptr<const Path> path_;  // of a drive, as soon as its way is known
  std::shared_ptr<const RecordedPoses> recorded_;
  double offLines_ = 0;  // m, how far the path leaves the straight lines between waypoints
  std::size_t waypoints_ = 0;
  std::optional<RandomWay> random_;
  double acceleration_ = 0;  // m/s^2; 0: at one speed
  std::vector<DriveStop> stops_;
  std::optional<SpeedProfile> profile_;
  std::vector<LaneChange> laneChanges_;
  Sway sway_;
  std::optional<GroundOptions> ground_;
  std::shared_ptr<const GroundProfile> profileOfGround_;
};

// How many trajectories an item of the YAML is: `drives` of a random drive, else 1. Throws InputError.
std::uint32_t countDrives(const Value& value);

// `fallbackPeriod` is the time between frames (s) where the YAML gives none; callers pass the period of the first
// sensor. Throws InputError.
// `lanes`: what `along` means; null where the caller knows of none. `seed`: of how the vehicle sways. `drive`: which of
// several random drives; its number then ends the name. `longestTurn`: the longest revolution of a sensor (s), in which
// the vehicle drives on after the last frame has begun.
Trajectory readTrajectory(const Value& value, const std::string& name, double fallbackPeriod,
                          const SceneLanes* lanes = nullptr, std::uint64_t seed = 0, std::uint32_t drive = 0,
                          double longestTurn = 0);

}  // namespace scanmill
