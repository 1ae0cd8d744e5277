#include "pipeline/scenes/scene_probe.h"

#include <algorithm>
#include <cmath>

namespace scanmill {
namespace {

constexpr double kBoundsMargin = 1;  // m, around the scene's bounds

// Returns the distance (m) along a ray at which it leaves the slab between `low` and `high` along one axis; negative if
// no point of the ray is in the slab. `start`, `direction`: the ray's coordinates along this axis.
double slabExit(double low, double high, double start, double direction) {
  if (direction == 0) return low <= start && start <= high ? INFINITY : -1;
  return ((direction > 0 ? high : low) - start) / direction;
}

}  // namespace

SceneProbe::SceneProbe(const Scene& scene, const Method* method, const MethodEntry* entry)
    : scene_(scene), bounds_(scene.bounds()), method_(method) {
  if (method != nullptr && entry != nullptr && entry->can.reference) return;
  own_ = makeReference(scene);
  method_ = own_.get();
}

double SceneProbe::endOf(const Ray& ray) const {
  const Vec3d margin{kBoundsMargin, kBoundsMargin, kBoundsMargin};
  const Box box{bounds_.low - margin, bounds_.high + margin};
  return std::min({slabExit(box.low.x, box.high.x, ray.from.x, ray.direction.x),
                   slabExit(box.low.y, box.high.y, ray.from.y, ray.direction.y),
                   slabExit(box.low.z, box.high.z, ray.from.z, ray.direction.z)});
}

std::vector<std::optional<SceneProbe::Hit>> SceneProbe::first(const std::vector<Ray>& rays, double reach) const {
  std::vector<std::optional<Hit>> firstHits(rays.size());
  // No ray needs to reach beyond the scene; a shorter reach saves the method work.
  double end = -1;
  for (const Ray& ray : rays) end = std::max(end, endOf(ray));
  reach = std::min(reach, end);
  if (!(reach > 0)) return firstHits;
  const Vec3d sensor = rays.front().from;
  auto table = std::make_shared<BeamTable>();
  table->rings = 1;
  table->columns = static_cast<std::uint32_t>(rays.size());
  table->period = 1;
  table->maxRange = reach;
  for (const Ray& ray : rays) {
    table->direction.push_back(ray.direction);
    table->origin.emplace_back(Vec3f(ray.from - sensor));
    table->time.push_back(0);
  }
  const Shot shot{.beams = table, .worldFromSensor = {{{}, sensor}}};
  Hits hits;
  method_->trace(shot, Channels(Channel::Range) | Channel::Normal | Channel::Semantic | Channel::Instance, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits.hit(i)) continue;
    const double distance = double{hits.range[i]};
    firstHits[i] = Hit{.distance = distance,
                       .position = rays[i].from + rays[i].direction * distance,
                       .normal = Vec3d(hits.normal[i]),
                       .semantic = hits.semantic[i],
                       .instance = hits.instance[i]};
  }
  return firstHits;
}

}  // namespace scanmill
