#pragma once

// Worlds near sensors, built when they are first needed.

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "methods/world/world.h"

namespace scanmill {

// Caches worlds. Their origins lie on a grid of 1024 m anchored at the scene's centre, so that they depend on the shot
// alone and move with the scene. If something moves, each revolution has its own world, for which little more is built
// than the placement of shared meshes; one more world than there are threads is cached. Origins of moving worlds lie on
// a grid of 16 m, since rounding errors grow with the distance from the origin.
class Worlds {
 public:
  // The scene must outlive it.
  Worlds(const Scene& scene, Instancing instancing, const HierarchyOptions& options);

  // Returns the world whose origin is nearest to the sensor (m). Safe to call from several threads.
  std::shared_ptr<const World> near(const Vec3d& sensor) const { return near(sensor, 0, 0); }
  // The same for the revolution that starts at `time` and takes `duration` (s); both matter only if something moves.
  std::shared_ptr<const World> near(const Vec3d& sensor, double time, double duration) const;
  bool moves() const { return moves_; }
  std::string embree() const { return embreeVersion(device_.get()); }  // version of the library
  bool instanced(std::size_t mesh) const { return instanced_[mesh]; }
  // Returns how many triangles a world and the meshes that it shares have: each baked copy counts, each shared mesh
  // counts once.
  std::uint64_t triangles() const;
  // Returns about how many bytes these triangles take.
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
