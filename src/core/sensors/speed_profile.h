#pragma once

// The distance that a vehicle has driven along its path, as a function of time.

#include <vector>

namespace scanmill {

class Path;

// A place on the path at which a vehicle stops for some time.
struct DriveStop {
  double at = 0;    // m along the path
  double wait = 0;  // s, duration of the stop
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
  double distance(double time) const;
  double speed(double time) const;  // returns the speed (m/s) at a time (s)
  // Returns the first time (s) at which the vehicle has driven `distance` (m, at most the path's length).
  double timeAt(double distance) const;

 private:
  // The state of the vehicle at a place on the path; between two nodes the acceleration is constant.
  struct Node {
    double time, distance, speed;
  };
  std::vector<Node> nodes_;
};

}  // namespace scanmill
