#pragma once

// What stands in the voxels of a grid: the truth that the completion of scenes is trained on.

#include <cstdint>
#include <map>
#include <unordered_set>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"
#include "scene/voxel_grid.h"

namespace scanmill {

struct VoxelLabels {
  // The class of each voxel, as points on the surfaces in it have it; 0: it is empty, or of no class.
  std::vector<std::uint16_t> label;
  // Indices, ascending, of the voxels that are not empty but whose class is 0.
  std::vector<std::uint32_t> unlabeled;
};

// Made once for a scene, which must outlive it; safe to use from several threads.
class SceneVoxels {
 public:
  explicit SceneVoxels(const Scene& scene);

  // A voxel is empty where no triangle has any area in it; surfaces that only touch it do not count. Else its class is
  // the one with the largest area of triangles in it, as they stand at a time (s since the drive began); of classes
  // with equal areas (to 1e-9) the one with the smallest id. What moves has the ontology's class for that, if there is
  // one, whether or not it moves at the time. Solids are hollow: what is within their surfaces is empty. Surfaces that
  // a texture cuts out by its alpha, such as leaves, count whole.
  //
  // `worldFromGrid`: where the frame of the grid stands. The result does not depend on the number of threads.
  VoxelLabels labels(const VoxelGrid& grid, const Pose& worldFromGrid, double time) const;

  // What it takes besides the scene.
  std::uint64_t memoryBytes() const;

 private:
  struct PlacedBlock;
  struct Near;

  Near nearOf(const VoxelGrid& grid, const Pose& worldFromGrid, double time) const;
  std::vector<std::uint16_t> classesOf(const Instance& instance, const Mesh& mesh) const;

  const Scene& scene_;
  std::vector<std::vector<Box>> blocks_;                  // of each mesh: boxes of so many triangles after another
  std::vector<Box> bounds_;                               // of each mesh
  std::unordered_set<std::uint32_t> moving_;              // instance ids
  std::map<std::uint16_t, std::uint16_t> movingClasses_;  // by the class of what stands still
};

}  // namespace scanmill
