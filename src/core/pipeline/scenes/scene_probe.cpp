#include "pipeline/scenes/scene_probe.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

SceneProbe::SceneProbe(const Scene& scene, const Method* method, const MethodEntry* entry)
    : scene_(scene), bounds_(scene.bounds()), method_(method) {
  if (method != nullptr && entry != nullptr && entry->can.reference) return;
  own_ = makeReference(scene);
  method_ = own_.get();
}

double SceneProbe::endOf(const Ray& ray) const {
  constexpr double kMargin = 1;  // m, around the scene's bounds
  double end = INFINITY;
  for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    const double low = bounds_.low.*axis - kMargin;
    const double high = bounds_.high.*axis + kMargin;
    const double start = ray.from.*axis;
    const double direction = ray.direction.*axis;
    if (direction == 0 && !(low <= start && start <= high)) return -1;
    if (direction != 0) end = std::min(end, ((direction > 0 ? high : low) - start) / direction);
  }
  return end;
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

SceneGround::SceneGround(const Scene& scene, std::vector<std::uint16_t> classes)
    : scene_(scene), classes_(std::move(classes)), heights_(scene, [this](std::uint16_t id) { return isGround(id); }) {
  heights_.update();
}

bool SceneGround::isGround(std::uint16_t semantic) const {
  if (!classes_.empty()) return std::ranges::find(classes_, semantic) != classes_.end();
  const SemanticClass* const semanticClass = scene_.ontology.find(semantic);
  return semanticClass == nullptr || !semanticClass->thing;
}

std::optional<double> SceneGround::under(const Vec3d& position) const {
  const auto surface = heights_.under(position, [&](const SurfaceHeights::Surface& s) { return isGround(s.semantic); });
  return surface ? std::optional(surface->height) : std::nullopt;
}

std::optional<double> SceneGround::near(const Vec3d& position) const {
  constexpr double kMostDistance = 1.5;  // m, see Ground::near()
  for (const double offset : {0.0, kBesideSeam}) {
    std::optional<double> nearest;
    for (const SurfaceHeights::Surface& s : heights_.at(position.x + offset, position.y + offset)) {
      const double distance = std::fabs(s.height - position.z);
      if (distance > kMostDistance || s.slope > kSteepestGround || !isGround(s.semantic)) continue;
      if (!nearest || distance < std::fabs(*nearest - position.z)) nearest = s.height;
    }
    if (nearest) return nearest;
  }
  return std::nullopt;
}

}  // namespace scanmill
