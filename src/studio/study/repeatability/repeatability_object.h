#pragma once

// The thing that repeated scans look at, and how far points lie from it.

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
  // The distance (m) from a point of the world to the box; 0 inside it. It is exact where the mesh's axes stay
  // perpendicular in the world.
  double distance(const Vec3d& point) const;

 private:
  std::string name_;
  Affine worldFromMesh_, meshFromWorld_;
  Box box_;
};

// All things of a scene, in the order of their instance ids.
std::vector<BoxedThing> boxedThings(const Scene& scene);

// The thing with this name that is nearest to `from`; where the name is empty, the nearest thing of all. Throws
// InputError, which names the scene, where there is none.
const BoxedThing& thingToWatch(const std::vector<BoxedThing>& things, const std::string& name, const Vec3d& from,
                               const Scene& scene);

}  // namespace scanmill
