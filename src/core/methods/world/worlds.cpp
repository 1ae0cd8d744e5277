#include "methods/world/worlds.h"

#include <cmath>

#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr double kOriginGrid = 1024;        // m, spacing of the worlds' origins if nothing moves
constexpr double kMovingOriginGrid = 16;    // m, spacing of the worlds' origins if something moves
constexpr std::size_t kWorldsInMemory = 2;  // number of cached worlds if nothing moves, for two neighbouring origins

constexpr std::uint64_t kBytesPerTriangle = 150;  // bytes, measured: hierarchy, corners and records

Vec3d centerOf(const Box& box) {
  return box.empty() ? Vec3d{} : box.center();
}

}  // namespace

Worlds::Worlds(const Scene& scene, Instancing instancing, const HierarchyOptions& options)
    : scene_(scene),
      options_(options),
      anchor_(centerOf(scene.bounds())),
      device_(makeDevice()),
      moves_(worldsMove(scene, instancing)),
      instanced_(instancedMeshes(scene, instancing)),
      shared_(device_.get(), scene, instanced_, options, moves_) {}

std::uint64_t Worlds::triangles() const {
  std::uint64_t triangles = 0;
  for (const Instance& i : scene_.instances)
    triangles += instanced_[i.mesh] ? 0 : scene_.meshes[i.mesh].triangles.size();
  for (std::size_t m = 0; m < scene_.meshes.size(); ++m) {
    triangles += instanced_[m] ? scene_.meshes[m].triangles.size() : 0;
  }
  return triangles;
}

std::uint64_t Worlds::memoryBytes() const {
  return triangles() * kBytesPerTriangle;
}

std::shared_ptr<const World> Worlds::near(const Vec3d& sensor, double reach, double time, double duration,
                                          const std::shared_ptr<const Placements>& placed) const {
  const double grid = moves_ ? kMovingOriginGrid : kOriginGrid;
  const auto cell = [grid](double d) { return std::round(d / grid) * grid; };
  const Vec3d offset = sensor - anchor_;
  const Vec3d origin = anchor_ + Vec3d{cell(offset.x), cell(offset.y), cell(offset.z)};
  Revolution revolution;
  if (moves_) {
    // Rounds up, so that shots of one revolution that differ little share a world.
    revolution = {time, duration, std::ceil((length(sensor - origin) + reach) / grid) * grid, placed};
  }
  const std::shared_ptr<Slot> slot = slotOf(origin, revolution);
  std::call_once(slot->built, [&] {
    slot->world = buildWorld(device_.get(), scene_, origin, instanced_, shared_, options_, slot->revolution);
  });
  return {slot, slot->world.get()};
}

std::shared_ptr<Worlds::Slot> Worlds::slotOf(const Vec3d& origin, const Revolution& revolution) const {
  const auto isOwn = [&](const std::shared_ptr<Slot>& slot) {
    const Revolution& known = slot->revolution;
    return slot->origin == origin && known.time == revolution.time && known.duration == revolution.duration &&
           known.placed == revolution.placed && known.reach >= revolution.reach;
  };
  const auto most = moves_ ? static_cast<std::size_t>(threadCount()) + 1 : kWorldsInMemory;
  const std::scoped_lock lock(mutex_);
  return worlds_.findOrAdd(isOwn, most, [&] {
    auto slot = std::make_shared<Slot>();
    slot->origin = origin;
    slot->revolution = revolution;
    return slot;
  });
}

}  // namespace scanmill
