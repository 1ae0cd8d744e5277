#include "scene/placements.h"

#include <cmath>

#include "scene/scene.h"

namespace scanmill {

Affine RigidMotion::at(double seconds) const {
  if (!moves()) return worldFromMesh;
  Affine placed = worldFromMesh;
  const double rate = length(turning);
  if (rate > 0) {
    const double halfAngle = rate * seconds / 2;
    const Vec3d quaternionVector = turning * (std::sin(halfAngle) / rate);
    placed.linear =
        toMatrix(Quat{std::cos(halfAngle), quaternionVector.x, quaternionVector.y, quaternionVector.z}) * placed.linear;
  }
  placed.translation += velocity * seconds;
  return placed;
}

const RigidMotion* Placements::find(std::uint32_t instance) const {
  const auto entry = placed_.find(instance);
  return entry == placed_.end() ? nullptr : &entry->second;
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
