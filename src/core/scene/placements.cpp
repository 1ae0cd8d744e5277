#include "scene/placements.h"

#include <cmath>

#include "scene/scene.h"

namespace scanmill {

Affine RigidMotion::at(double after) const {
  if (!moves()) return worldFromMesh;
  Affine placed = worldFromMesh;
  const double rate = length(turning);
  if (rate > 0) {
    const double half = rate * after / 2;
    const Vec3d axis = turning * (std::sin(half) / rate);
    placed.linear = toMatrix(Quat{std::cos(half), axis.x, axis.y, axis.z}) * placed.linear;
  }
  placed.translation = placed.translation + velocity * after;
  return placed;
}

const RigidMotion* Placements::find(std::uint32_t instance) const {
  const auto found = placed_.find(instance);
  return found == placed_.end() ? nullptr : &found->second;
}

Affine worldFromMeshAt(const Instance& instance, std::uint32_t index, const Placements* placed, double time) {
  const RigidMotion* const placement = placed == nullptr ? nullptr : placed->find(index);
  return placement == nullptr ? instance.worldFromMeshAt(time) : placed->worldFromMeshAt(*placement, time);
}

Affine rigidPartOf(const Affine& transform) {
  const Vec3d x = normalized(transform.linear.x);
  const Vec3d z = normalized(cross(x, transform.linear.y));
  return {{x, cross(z, x), z}, transform.translation};
}

}  // namespace scanmill
