#pragma once

// Worlds near sensors, built when they are first needed.

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "methods/world/world.h"

namespace scanmill {

// Origins lie on a grid of 1024 m anchored at the scene's centre, so that they depend on the shot alone and move with
// the scene. Where something moves each revolution has a world of its own, in which little but places of shared meshes
// is built; as many are kept as threads work on revolutions, and one. Their grid is of 16 m: the nearer the origin, the
// less is rounded, and the fewer rays a device leaves to the processor.
class Worlds {
 public:
  // The scene must outlive it.
  Worlds(const Scene& scene, Instancing instancing, const HierarchyOptions& options);

  // The world whose origin is nearest to the sensor (m). Safe to call from several threads.
  std::shared_ptr<const World> near(const Vec3d& sensor) const { return near(sensor, 0, 0); }
  // Where something moves: as it is from a time on, for a duration (s).
  std::shared_ptr<const World> near(const Vec3d& sensor, double time, double duration) const;
  bool moves() const { return moves_; }
  std::string embree() const { return embreeVersion(device_.get()); }  // its version
  bool instanced(std::size_t mesh) const { return instanced_[mesh]; }
  // Of a world with all that it shares with others: each baked copy, each shared mesh once.
  std::uint64_t triangles() const;
  // What these take.
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
