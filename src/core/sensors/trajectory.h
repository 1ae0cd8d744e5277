#pragma once

// Where the vehicle is at each time: poses one by one, or waypoints driven at a speed.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

class Path;

// Piecewise path of worldFromVehicle over time.
//
// YAML, one of
//   poses: [{position: [x, y, z], yaw_deg: 90}, ...]        # one frame each; the vehicle stands still in each
//   waypoints: [[x, y, z], ...]                             # driven at `speed` (m/s), heading along the path
//   speed: 8.0
//   every_s: 0.1 | every_m: 1.0                             # a frame each (poses: every_s only, the time between two)
//   frames: 40                                              # optional limit; waypoints end the path where absent
//   name: loop                                              # optional
class Trajectory {
 public:
  static constexpr std::uint32_t kMaxFrames = 10'000'000;

  // Number of frames, and the time of each (s since the start).
  std::uint32_t frames() const { return frames_; }
  double frameTime(std::uint32_t frame) const { return frame * interval_; }

  // Pose at a time within the turn of a frame (`dt` seconds after its start). A listed pose stands still; a path is
  // driven to its end, where the vehicle stops.
  Pose pose(std::uint32_t frame, double dt) const;

  bool still() const { return path_ == nullptr; }  // the vehicle stands still in each frame
  double pathLength() const;                       // m; 0 for listed poses
  const std::string& name() const { return name_; }

 private:
  friend Trajectory readTrajectory(const Value& value, const std::string& name, double fallbackPeriod);
  std::string name_;
  std::uint32_t frames_ = 0;
  double interval_ = 0;               // s, from frame to frame
  double speed_ = 0;                  // m/s
  std::vector<Pose> poses_;           // one per frame where the vehicle stands still
  std::shared_ptr<const Path> path_;  // otherwise
};

// `fallbackPeriod` (s) is the time between frames where the YAML says none: the sensor's turn.
Trajectory readTrajectory(const Value& value, const std::string& name, double fallbackPeriod);

}  // namespace scanmill
