#pragma once

// Finds the object that repeated scans look at, and measures the distance of points from it.

#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// An object of a scene, with a bounding box along the axes of the object's mesh.
class BoxedThing {
 public:
  BoxedThing(std::string name, const Affine& worldFromMesh, const Box& box);

  const std::string& name() const { return name_; }
  Vec3d center() const { return worldFromMesh_ * box_.center(); }
  // Returns the distance (m) from a point in the world frame to the bounding box; 0 inside of the box. The result is
  // exact if the mesh's axes are perpendicular in the world frame too.
  double distance(const Vec3d& point) const;

 private:
  std::string name_;
  Affine worldFromMesh_, meshFromWorld_;
  Box box_;
};

// Returns all object instances of a scene, sorted by instance id.
std::vector<BoxedThing> boxedThings(const Scene& scene);

// Returns the object with this name that is nearest to the point `from` (world frame, m); if the name is empty, the
// nearest of all objects. Throws InputError with the scene's name if there is no such object.
const BoxedThing& thingToWatch(const std::vector<BoxedThing>& things, const std::string& name, const Vec3d& from,
                               const Scene& scene);

}  // namespace scanmill
