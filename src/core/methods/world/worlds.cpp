#include "methods/world/worlds.h"

#include <cmath>

#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr double kOriginGrid = 1024;        // m, spacing of the worlds' origins if nothing moves
constexpr double kMovingOriginGrid = 16;    // m, spacing of the worlds' origins if something moves
constexpr std::size_t kWorldsInMemory = 2;  // number of cached worlds if nothing moves, for two neighbouring origins

constexpr std::uint64_t kBytesPerTriangle = 150;  // bytes, measured: hierarchy, corners and records

}  // namespace

Worlds::Worlds(const Scene& scene, Instancing instancing, const HierarchyOptions& options)
    : scene_(scene),
      options_(options),
      gridCentre_(scene.bounds().empty() ? Vec3d{} : scene.bounds().center()),
      device_(makeDevice()),
      moves_(worldsMove(scene, instancing)),
      instanced_(instancedMeshes(scene, instancing)),
      shared_(device_.get(), scene, instanced_, options, moves_) {}

std::uint64_t Worlds::memoryBytes() const {
  std::uint64_t triangles = 0;
  for (const Instance& i : scene_.instances) {
    triangles += instanced_[i.mesh] ? 0 : scene_.meshes[i.mesh].triangles.size();
  }
  for (std::size_t m = 0; m < scene_.meshes.size(); ++m) {
    triangles += instanced_[m] ? scene_.meshes[m].triangles.size() : 0;
  }
  return triangles * kBytesPerTriangle;
}

std::shared_ptr<const World> Worlds::near(const Vec3d& sensor, double reach, double time, double duration,
                                          const std::shared_ptr<const Placements>& placed) const {
  const double grid = moves_ ? kMovingOriginGrid : kOriginGrid;
  const auto snapped = [grid](double coordinate) { return std::round(coordinate / grid) * grid; };
  const Vec3d offset = sensor - gridCentre_;
  const Vec3d origin = gridCentre_ + Vec3d{snapped(offset.x), snapped(offset.y), snapped(offset.z)};
  Revolution revolution;
  if (moves_) {
    // The reach is rounded up, so that shots of one revolution whose reaches differ little share a world.
    revolution = {.time = time,
                  .duration = duration,
                  .reach = std::ceil((length(sensor - origin) + reach) / grid) * grid,
                  .placed = placed};
  }
  const std::shared_ptr<Slot> slot = slotOf(origin, revolution);
  std::call_once(slot->built, [&] {
    slot->world = buildWorld(device_.get(), scene_, origin, instanced_, shared_, options_, slot->revolution);
  });
  return {slot, slot->world.get()};
}

// Returns the slot of a world with this origin and revolution, and at least this reach; a new slot if no slot fits.
std::shared_ptr<Worlds::Slot> Worlds::slotOf(const Vec3d& origin, const Revolution& revolution) const {
  const auto fits = [&](const std::shared_ptr<Slot>& slot) {
    const Revolution& cached = slot->revolution;
    return slot->origin == origin && cached.time == revolution.time && cached.duration == revolution.duration &&
           cached.placed == revolution.placed && cached.reach >= revolution.reach;
  };
  const auto mostWorlds = moves_ ? static_cast<std::size_t>(threadCount()) + 1 : kWorldsInMemory;
  const std::scoped_lock lock(mutex_);
  return worlds_.findOrAdd(fits, mostWorlds, [&] {
    auto slot = std::make_shared<Slot>();
    slot->origin = origin;
    slot->revolution = revolution;
    return slot;
  });
}

}  // namespace scanmill
