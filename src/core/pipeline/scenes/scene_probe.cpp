#include "pipeline/scenes/scene_probe.h"

#include <memory>

namespace scanmill {
namespace {

constexpr double kBehind = 1e-3;  // distance behind a hit at which the next ray starts (m)
constexpr std::size_t kMost = 100;

}  // namespace

SceneProbe::SceneProbe(const Scene& scene, const Method* method, const MethodEntry* entry)
    : scene_(scene), method_(method) {
  if (method != nullptr && entry != nullptr && entry->can.reference) return;
  own_ = makeReference(scene);
  method_ = own_.get();
}

std::vector<std::optional<SceneProbe::Met>> SceneProbe::first(const std::vector<Ray>& rays, double reach) const {
  std::vector<std::optional<Met>> met(rays.size());
  if (rays.empty()) return met;
  auto table = std::make_shared<BeamTable>();
  table->rings = 1;
  table->columns = static_cast<std::uint32_t>(rays.size());
  table->period = 1;
  table->maxRange = reach;
  const Vec3d anchor = rays.front().from;
  for (const Ray& ray : rays) {
    table->direction.push_back(ray.direction);
    table->origin.emplace_back(Vec3f(ray.from - anchor));
    table->time.push_back(0);
  }
  Shot shot;
  shot.worldFromSensor = {{{}, anchor}};
  shot.beams = table;
  Hits hits;
  method_->trace(shot, Channels(Channel::Range) | Channel::Normal | Channel::Semantic | Channel::Instance, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits.hit(i)) continue;
    const double distance = double{hits.range[i]};
    met[i] = Met{distance, rays[i].from + rays[i].direction * distance, Vec3d(hits.normal[i]), hits.semantic[i],
                 hits.instance[i]};
  }
  return met;
}

std::vector<SceneProbe::Met> SceneProbe::all(const Ray& ray, double reach) const {
  std::vector<Met> found;
  double from = 0;
  while (found.size() < kMost && from < reach) {
    std::optional<Met> met = first(Ray{ray.from + ray.direction * from, ray.direction}, reach - from);
    if (!met) break;
    met->distance += from;
    from = met->distance + kBehind;
    found.push_back(*met);
  }
  return found;
}

}  // namespace scanmill
