#pragma once

// Worlds near sensors, each built when it is first needed.

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "methods/world/world.h"

namespace scanmill {

// Builds and caches worlds. Their origins are on a grid of 1024 m that starts at the scene's centre, so that a shot's
// world depends only on the shot. If something in the scene moves, each revolution has its own world; only the
// placements of the shared meshes are built for it. The cache has at most one more of these worlds than there are
// threads. Their origins are on a grid of 16 m, because rounding errors grow with the distance from the origin.
class Worlds {
 public:
  // The scene must outlive this object.
  Worlds(const Scene& scene, Instancing instancing, const HierarchyOptions& options);

  // Returns the world whose origin is nearest to `sensor`, a position in the world frame (m). Safe to call from several
  // threads.
  std::shared_ptr<const World> near(const Vec3d& sensor) const { return near(sensor, 0, 0); }
  // Returns the world for the revolution that starts at `time` and takes `duration` (s); both matter only if something
  // moves.
  std::shared_ptr<const World> near(const Vec3d& sensor, double time, double duration) const;
  bool moves() const { return moves_; }
  std::string embree() const { return embreeVersion(device_.get()); }  // version of the library
  bool instanced(std::size_t mesh) const { return instanced_[mesh]; }
  // Returns the number of triangles of a world and its shared meshes. A baked triangle counts once per instance, a
  // triangle of a shared mesh counts once.
  std::uint64_t triangles() const;
  // Returns approximately how many bytes the triangles that triangles() counts take.
  std::uint64_t memoryBytes() const;

 private:
  const Scene& scene_;
  HierarchyOptions options_;
  Vec3d anchor_;
  DeviceHandle device_;
  bool moves_;
  std::vector<bool> instanced_;
  SharedMeshes shared_;
  mutable std::mutex mutex_;
  mutable std::list<std::shared_ptr<const World>> worlds_;
};

}  // namespace scanmill
