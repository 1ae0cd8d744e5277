#pragma once

// Where a caller places objects of a scene for one shot, in place of the positions that the scene gives them: the
// objects that another simulator moves.
//
//   auto placed = std::make_shared<Placements>(shot.time);
//   placed->set(17, {.worldFromMesh = pose, .velocity = {5, 0, 0}});  // instance 17 drives at 5 m/s
//   shot.placed = std::move(placed);

#include <cstdint>
#include <unordered_map>

#include "base/vec.h"

namespace scanmill {

struct Instance;

// The rigid motion of an instance during a shot.
struct Placement {
  bool hidden = false;   // true: the instance is not in the scene during the shot
  Affine worldFromMesh;  // at the start of the shot
  Vec3d velocity;        // m/s, world axes: velocity of the mesh's origin
  Vec3d turning;         // rad/s, world axes: angular velocity about the mesh's origin

  bool moves() const { return velocity != Vec3d{} || turning != Vec3d{}; }
  // Returns the transform `after` seconds after the start of the shot, at constant velocity and angular velocity.
  Affine at(double after) const;
};

class Placements {
 public:
  // `time`: the start of the shot (s since the drive began).
  explicit Placements(double time) : time_(time) {}

  void set(std::uint32_t instance, const Placement& placement) { placed_[instance] = placement; }
  // Returns the placement of an instance (index in Scene::instances); null if it has none.
  const Placement* find(std::uint32_t instance) const;
  // Returns the placement's transform at a time (s since the drive began).
  Affine worldFromMeshAt(const Placement& placement, double time) const { return placement.at(time - time_); }

 private:
  double time_;
  std::unordered_map<std::uint32_t, Placement> placed_;
};

// Returns the transform of an instance with this index at a time (s since the drive began): that of its placement or,
// if `placed` is null or has none, that of the scene.
Affine worldFromMeshAt(const Instance& instance, std::uint32_t index, const Placements* placed, double time);

// Returns the pose of an instance's frame without the scale of its transform, so that `transform` is this pose times a
// matrix of scales and shears. A mirrored transform leaves the mirroring to that matrix.
Affine rigidPartOf(const Affine& transform);

}  // namespace scanmill
