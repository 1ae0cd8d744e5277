#pragma once

// Poses and velocities that a caller sets for instances of a scene during one shot, for example because another
// simulator moves them. This header is installed because sensors/shot.h includes it.
//
//   Placements placed(2.0);  // for a shot that starts at 2 s; Shot::placed points to it
//   placed.set(17, {.worldFromMesh = {{}, {10, 0, 0}}, .velocity = {5, 0, 0}});  // instance 17 drives at 5 m/s
//   const Vec3d later = placed.worldFromMeshAt(*placed.find(17), 2.1).translation;  // (10.5, 0, 0) m

#include <cstdint>
#include <unordered_map>

#include "base/vec.h"

namespace scanmill {

struct Instance;

// The rigid motion of an instance during a shot.
struct RigidMotion {
  bool hidden = false;        // true: the instance is not in the scene during the shot
  Affine worldFromMesh = {};  // at the start of the shot
  Vec3d velocity = {};        // m/s, world axes: velocity of the mesh's origin
  Vec3d turning = {};         // rad/s, world axes: angular velocity about the mesh's origin

  bool moves() const { return velocity != Vec3d{} || turning != Vec3d{}; }
  // Returns the transform `seconds` after the start of the shot, at constant velocity and angular velocity.
  Affine at(double seconds) const;
};

class Placements {
 public:
  // `time`: the start of the shot (s since the drive began).
  explicit Placements(double time) : time_(time) {}

  void set(std::uint32_t instance, const RigidMotion& motion) { placed_[instance] = motion; }
  // Returns the placement of an instance (index in Scene::instances); null if it has none.
  const RigidMotion* find(std::uint32_t instance) const;
  // Returns the placement's transform at a time (s since the drive began).
  Affine worldFromMeshAt(const RigidMotion& motion, double time) const { return motion.at(time - time_); }

 private:
  double time_;
  std::unordered_map<std::uint32_t, RigidMotion> placed_;
};

// Returns the transform of the instance with this index at a time (s since the drive began): from its placement, or
// from the scene if `placed` is null or has no placement of this instance.
Affine worldFromMeshAt(const Instance& instance, std::uint32_t index, const Placements* placed, double time);

// Returns the rigid part of an instance's transform: `transform` is the returned pose times a matrix that only scales
// and shears, and also mirrors if `transform` mirrors.
Affine rigidPartOf(const Affine& transform);

}  // namespace scanmill
