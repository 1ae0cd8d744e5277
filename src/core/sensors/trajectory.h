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
#include "sensors/speed_profile.h"
#include "sensors/sway.h"

namespace scanmill {

class Path;

// The pose worldFromVehicle over time. In YAML it has either poses or waypoints:
//
//   poses: [{position: [x, y, z], yaw_deg: 90}, ...]        # one frame each; the vehicle stands still in each
//   waypoints: [[x, y, z], ...]                             # driven at `speed` (m/s), heading along the path
//   along: lane                                             # in place of waypoints: those of the caller; or turns
//   speed: 8.0
//   acceleration: 1.5                                       # m/s^2: from rest to rest, slower in bends; see
//   speed_profile.h stops: [{at: 60, wait: 4}]                              # m along the way, s; needs acceleration
//   lane_changes: [{at: 80, left: 3, over: 30}]             # m along the way, m to the left by the end of so many m
//   sway: {roll_deg: 0.4, pitch_deg: 0.3, heave_m: 0.01}    # see sway.h
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

  bool still() const { return path_ == nullptr; }  // the vehicle stands still in each frame
  double pathLength() const;                       // m; 0 for listed poses
  const std::string& name() const { return name_; }
  // Of a drive along the turns of a town: how many there are.
  std::optional<int> turns() const { return turns_; }

 private:
  friend Trajectory readTrajectory(const Value& value, const std::string& name, double fallbackPeriod,
                                   const SceneLanes* lanes, std::uint64_t seed);
  struct LaneChange {
    double at, left, over;  // m
  };
  static std::vector<LaneChange> readLaneChanges(const Value& value, double length);

  std::string name_;
  std::uint32_t frames_ = 0;
  double interval_ = 0;     // s, from frame to frame
  double everyMetres_ = 0;  // of a vehicle that accelerates, in place of that; 0: none
  double speed_ = 0;        // m/s
  std::optional<int> turns_;
  std::vector<Pose> poses_;           // one per frame where the vehicle stands still
  std::shared_ptr<const Path> path_;  // otherwise
  std::optional<SpeedProfile> profile_;
  std::vector<LaneChange> laneChanges_;
  Sway sway_;
};

// `fallbackPeriod` is the time between frames (s) where the YAML gives none; callers pass the period of the first
// sensor. Throws InputError.
// `lanes`: what `along` means; null where the caller knows of none. `seed`: of how the vehicle sways.
Trajectory readTrajectory(const Value& value, const std::string& name, double fallbackPeriod,
                          const SceneLanes* lanes = nullptr, std::uint64_t seed = 0);

}  // namespace scanmill
