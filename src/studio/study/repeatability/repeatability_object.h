#pragma once

// The object that repeated scans look at, and the distance of points from it.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// An object of a scene with its box along the axes of its mesh. If the object is a box itself, the two are equal.
class BoxedThing {
 public:
  BoxedThing(std::string name, const Affine& worldFromMesh, const Box& box);

  const std::string& name() const { return name_; }
  Vec3d center() const { return worldFromMesh_ * box_.center(); }
  // Returns the distance (m) from a point of the world to the box; 0 inside it. The distance is exact if the mesh's
  // axes stay perpendicular in the world.
  double distance(const Vec3d& point) const;

 private:
  std::string name_;
  Affine worldFromMesh_, meshFromWorld_;
  Box box_;
};

// Returns all objects of a scene, in the order of their instance ids.
std::vector<BoxedThing> boxedThings(const Scene& scene);

// Returns the object with this name that is nearest to `from`, or the nearest object of all if the name is empty.
// Throws InputError that names the scene if there is no such object.
const BoxedThing& thingToWatch(const std::vector<BoxedThing>& things, const std::string& name, const Vec3d& from,
                               const Scene& scene);

}  // namespace scanmill
