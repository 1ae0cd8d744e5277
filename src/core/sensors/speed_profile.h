#pragma once

// How far a vehicle has come along its path at each time.

#include <vector>

#include "base/path.h"

namespace scanmill {

// Where a vehicle comes to rest for a while.
struct DriveStop {
  double at = 0;    // m along the path
  double wait = 0;  // s
};

class SpeedProfile {
 public:
  // At one speed (m/s) all along a path of this length (m).
  SpeedProfile(double length, double speed);
  // From rest at the path's start to rest at its end and at each stop, as fast as the speed (m/s), the acceleration and
  // braking (m/s^2), and kSideways in bends allow. The stops lie within the path, in their order.
  SpeedProfile(const Path& path, double speed, double acceleration, const std::vector<DriveStop>& stops);

  static constexpr double kSideways = 2;  // m/s^2

  double duration() const { return nodes_.back().time; }  // s
  // m along the path at a time (s): its start before, its end afterwards.
  double distance(double time) const;
  double speed(double time) const;  // m/s
  // The first time (s) at which it has come so far (m, at most the path's length).
  double timeAt(double distance) const;

 private:
  // From one to the next the acceleration is constant.
  struct Node {
    double time, distance, speed;
  };
  std::vector<Node> nodes_;
};

}  // namespace scanmill
