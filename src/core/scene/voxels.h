#pragma once

// Labels the voxels of a grid: the ground truth for semantic scene completion.

#include <cstdint>
#include <map>
#include <unordered_set>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"
#include "scene/voxel_grid.h"

namespace scanmill {

struct VoxelLabels {
  // The class id of each voxel, as in the column `label` of points; 0: the voxel is empty or unlabeled.
  std::vector<std::uint16_t> label;
  // Indices, ascending, of the voxels that are not empty but whose class is 0.
  std::vector<std::uint32_t> unlabeled;
};

// Labels voxels of a scene, which must outlive this object. Safe to use from several threads.
class SceneVoxels {
 public:
  explicit SceneVoxels(const Scene& scene);

  // Returns the class of each voxel at a time (s since the drive began): the class whose triangles have the largest
  // area in the voxel or, if areas are equal (to 1e-9), the smallest class id. A voxel is empty if no triangle has any
  // area in it; surfaces that only touch it do not count. An object that ever moves has the ontology's class for moving
  // objects, if there is one, even while it stands still. Solids are hollow: voxels inside their surfaces are empty.
  // Alpha-tested surfaces, such as leaves, count with their full area.
  // `worldFromGrid`: pose of the grid's frame in the world. The result does not depend on the number of threads.
  VoxelLabels labels(const VoxelGrid& grid, const Pose& worldFromGrid, double time) const;

  // Returns the memory that this object takes, without the scene (bytes).
  std::uint64_t memoryBytes() const;

 private:
  std::vector<std::uint16_t> classesOf(const Instance& instance, const Mesh& mesh) const;

  const Scene& scene_;
  std::vector<std::vector<Box>> blocks_;                  // boxes of kBlock consecutive triangles, by mesh
  std::vector<Box> bounds_;                               // box of all triangles, by mesh
  std::unordered_set<std::uint32_t> movingIds_;           // instance ids of objects that move at some time
  std::map<std::uint16_t, std::uint16_t> movingClasses_;  // class of objects at rest -> class of moving objects
};

}  // namespace scanmill
