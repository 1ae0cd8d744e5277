#pragma once

// Builds and caches the worlds near sensors.

#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include "base/recently_used.h"
#include "methods/world/world.h"

namespace scanmill {

// Builds and caches worlds. The origins of worlds are on a grid with a spacing of 1024 m, one of whose points is the
// scene's centre, so that a shot's world depends only on the shot. If something in the scene moves, each revolution has
// its own world: the placements of the shared meshes that the revolution's rays can reach. The cache then has at most
// one more world than there are threads. As no world then serves many shots, the spacing is only 16 m, which keeps
// rounding errors small: they grow with the distance from the origin.
class Worlds {
 public:
  // The scene must outlive this object.
  Worlds(const Scene& scene, Instancing instancing, const HierarchyOptions& options);

  // Returns the world whose origin is nearest to `sensor` (m, world frame). If something moves, it is the world of the
  // revolution from `time` to time + duration (s), for rays that end less than `reach` (m) from `sensor`, with the
  // placements `placed` (Shot::placed); otherwise only `sensor` matters. Safe to call from several threads.
  std::shared_ptr<const World> near(const Vec3d& sensor, double reach = std::numeric_limits<double>::infinity(),
                                    double time = 0, double duration = 0,
                                    const std::shared_ptr<const Placements>& placed = nullptr) const;
  bool moves() const { return moves_; }
  std::string embree() const { return embreeVersion(device_.get()); }  // version of the library
  bool instanced(std::size_t mesh) const { return instanced_[mesh]; }
  // Returns approximately how many bytes the triangles of a world and its shared meshes take. A baked triangle counts
  // once per instance, a triangle of a shared mesh counts once.
  std::uint64_t memoryBytes() const;

 private:
  // A world that is built by the first thread that needs it, while the other threads that need it wait.
  struct Slot {
    Vec3d origin;
    Revolution revolution;
    std::once_flag built;
    std::unique_ptr<const World> world;
  };
  std::shared_ptr<Slot> slotOf(const Vec3d& origin, const Revolution& revolution) const;

  const Scene& scene_;
  HierarchyOptions options_;
  Vec3d gridCentre_;  // m, the scene's centre
  DeviceHandle device_;
  bool moves_;
  std::vector<bool> instanced_;
  SharedMeshes shared_;
  mutable std::mutex mutex_;
  mutable RecentlyUsed<std::shared_ptr<Slot>> worlds_;
};

}  // namespace scanmill
