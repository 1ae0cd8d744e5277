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
      anchor_(scene.bounds().empty() ? Vec3d{} : scene.bounds().center()),
      device_(makeDevice()),
      moves_(worldsMove(scene, instancing)),
      instanced_(instancedMeshes(scene, instancing)),
      shared_(buildSharedMeshes(device_.get(), scene, instanced_, options)) {}

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

std::shared_ptr<const World> Worlds::near(const Vec3d& sensor, double time, double duration) const {
  const double grid = moves_ ? kMovingOriginGrid : kOriginGrid;
  const auto cell = [grid](double d) { return std::round(d / grid) * grid; };
  const Vec3d offset = sensor - anchor_;
  const Vec3d origin = anchor_ + Vec3d{cell(offset.x), cell(offset.y), cell(offset.z)};
  if (!moves_) time = duration = 0;
  const std::scoped_lock lock(mutex_);
  for (auto it = worlds_.begin(); it != worlds_.end(); ++it) {
    if ((*it)->origin == origin && (*it)->time == time && (*it)->duration == duration) {
      worlds_.splice(worlds_.begin(), worlds_, it);
      return worlds_.front();
    }
  }
  const auto most = moves_ ? static_cast<std::size_t>(threadCount()) + 1 : kWorldsInMemory;
  if (worlds_.size() >= most) worlds_.pop_back();
  worlds_.push_front(buildWorld(device_.get(), scene_, origin, instanced_, shared_, options_, time, duration));
  return worlds_.front();
}

}  // namespace scanmill
