#pragma once

// The rigid motion of an object of a scene, over the time of a drive. This header is installed because scene/scene.h
// includes it.
//
//   const Movement movement(Vec3d{5, 0, 0});           // m/s
//   const Vec3d moved = movement.at(2.0).translation;  // (10, 0, 0) m

#include <memory>
#include <vector>

#include "base/vec.h"

namespace scanmill {

class Path;

inline constexpr double kFastestObject = 300;  // m/s, largest speed of an object

class Movement {
 public:
  // Moves in a straight line at this velocity (m/s, world axes), without turning.
  explicit Movement(const Vec3d& velocity);
  // Moves along a path at a constant speed (m/s), from the distance `start` (m) to the path's end, and stops there.
  Movement(std::shared_ptr<const Path> path, double start, double speed);
  // Moves along a path. `travelled` has the distances along the path (m) at the times 0, interval, 2 interval, ... (s);
  // distances between these times are interpolated linearly. The object stops at the last distance.
  Movement(std::shared_ptr<const Path> path, std::vector<double> travelled, double interval);

  // Returns the pose of the object in the world at a time (s since the drive began; earlier times count as 0). In its
  // own frame the object is at the origin and faces along x.
  Pose at(double time) const;
  // True if the pose ever changes.
  bool moves() const;

 private:
  Vec3d velocity_;                    // m/s; only without a path
  std::shared_ptr<const Path> path_;  // null: the object moves in a straight line
  std::vector<double> travelled_;     // m, distances along the path at the times 0, interval_, 2 interval_, ...
  double interval_ = 1;               // s
};

}  // namespace scanmill
