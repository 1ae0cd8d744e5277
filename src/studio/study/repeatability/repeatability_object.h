#pragma once

// The thing that repeated scans look at: its box, and what lies near it.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// A thing of a scene with the box around it along the axes of its own mesh, which for a box is the box itself.
class BoxedThing {
 public:
  BoxedThing(std::string name, const Affine& worldFromMesh, const Box& box);

  const std::string& name() const { return name_; }
  Vec3d center() const { return worldFromMesh_ * box_.center(); }
  // From a point of the world to the box (m); 0 inside. Exact where the mesh's axes stay perpendicular in the world.
  double distance(const Vec3d& point) const;

 private:
  std::string name_;
  Affine worldFromMesh_, meshFromWorld_;
  Box box_;
};

// All things, by instance id.
std::vector<BoxedThing> boxedThings(const Scene& scene);

// The thing with this name or, where the name is empty, the one nearest to `from`. Of several the nearest. Throws
// InputError that names the scene.
const BoxedThing& thingToWatch(const std::vector<BoxedThing>& things, const std::string& name, const Vec3d& from,
                               const Scene& scene);

}  // namespace scanmill
