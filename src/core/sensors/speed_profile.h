#pragma once

// The distance that a vehicle has driven along its path at each time.

#include <vector>

#include "base/path.h"

namespace scanmill {

// A place at which a vehicle stops for a while.
struct DriveStop {
  double at = 0;    // m along the path
  double wait = 0;  // s
};

class SpeedProfile {
 public:
  // Drives at one speed (m/s) all along a path of this length (m).
  SpeedProfile(double length, double speed);
  // Drives from rest at the path's start to rest at its end and at each stop, as fast as the speed (m/s), the
  // acceleration and braking (m/s^2), and in bends the lateral acceleration kSideways allow. The stops lie within the
  // path, in their order.
  SpeedProfile(const Path& path, double speed, double acceleration, const std::vector<DriveStop>& stops);

  static constexpr double kSideways = 2;  // m/s^2

  double duration() const { return nodes_.back().time; }  // s
  // Returns the distance along the path (m) at a time (s): that of the start before, that of the end afterwards.
  double distance(double time) const;
  double speed(double time) const;  // m/s
  // Returns the first time (s) at which the vehicle has driven this distance (m, at most the path's length).
  double timeAt(double distance) const;

 private:
  // Between two nodes the acceleration is constant.
  struct Node {
    double time, distance, speed;
  };
  std::vector<Node> nodes_;
};

}  // namespace scanmill
