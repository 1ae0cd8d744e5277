#pragma once

// How an object of a scene moves: rigidly, over the time of a drive.

#include <memory>
#include <vector>

#include "base/path.h"
#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

class Movement {
 public:
  // In a straight line, without turning (m/s).
  explicit Movement(const Vec3d& velocity);
  // Along a path at a constant speed (m/s), from `start` m on it; the end is where it stops.
  Movement(std::shared_ptr<const Path> path, double start, double speed);
  // Along a path: `travelled` m on it at the times 0, interval, 2 interval, ... (s), evenly in between; after the last
  // of these it stands.
  Movement(std::shared_ptr<const Path> path, std::vector<double> travelled, double interval);

  // What places the object, which stands at the origin and looks along x, in the world at a time (s since the drive
  // began; before that as at 0).
  Pose at(double time) const;
  // Whether it is ever anywhere else than at first.
  bool moves() const;

 private:
  Vec3d velocity_;
  std::shared_ptr<const Path> path_;  // null: a straight line
  std::vector<double> travelled_;
  double interval_ = 1;
};

// From YAML: {velocity: [x, y, z]} or {waypoints: [[x, y, z], ...], speed: m/s, start: m}. Throws InputError.
std::shared_ptr<const Movement> readMovement(const Value& value);

}  // namespace scanmill
