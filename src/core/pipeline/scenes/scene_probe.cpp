#include "pipeline/scenes/scene_probe.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scene/surface_heights.h"

namespace scanmill {
namespace {

constexpr double kBehindHit = 1e-3;  // m, distance behind a hit at which the next ray starts
constexpr std::size_t kMostHits = 100;
// Distance (m) along a ray after which all() moves the anchor, the point that the method takes for the sensor's
// position. Rare moves save work, since a method may build a hierarchy for each anchor. Ray tracing orders coplanar
// surfaces reliably up to 64 m from the anchor (kCoplanarCorners).
constexpr double kAnchorDistance = 48;
constexpr double kBoundsMargin = 1;  // m, around the scene's bounds
constexpr Vec3d kDown{0, 0, -1};

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

std::vector<std::optional<SceneProbe::Hit>> SceneProbe::first(const std::vector<Ray>& rays, double reach,
                                                              const std::optional<Vec3d>& anchor) const {
  std::vector<std::optional<Hit>> firstHits(rays.size());
  // No ray needs to reach beyond the scene; a shorter reach saves the method work.
  double end = -1;
  for (const Ray& ray : rays) end = std::max(end, endOf(ray));
  reach = std::min(reach, end);
  if (!(reach > 0)) return firstHits;
  const Vec3d sensor = anchor.value_or(rays.front().from);
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

std::vector<std::vector<SceneProbe::Hit>> SceneProbe::all(const std::vector<Ray>& rays, double reach) const {
  std::vector<std::vector<Hit>> hits(rays.size());
  std::vector<double> starts(rays.size(), 0.0);  // distances along the rays (m) from which the next hits are searched
  std::vector<std::size_t> unfinished(rays.size());  // indices of the rays that may have further hits
  std::iota(unfinished.begin(), unfinished.end(), std::size_t{0});
  double anchor = 0;  // distance along the first ray (m) of the position that the method takes for the sensor's
  while (!unfinished.empty()) {
    double nearestStart = reach;
    for (const std::size_t i : unfinished) nearestStart = std::min(nearestStart, starts[i]);
    if (nearestStart - anchor > kAnchorDistance) anchor = nearestStart;
    std::vector<Ray> remaining;
    remaining.reserve(unfinished.size());
    for (const std::size_t i : unfinished) {
      remaining.push_back({rays[i].from + rays[i].direction * starts[i], rays[i].direction});
    }
    const auto nextHits = first(remaining, reach - nearestStart, rays.front().from + rays.front().direction * anchor);
    std::vector<std::size_t> further;
    for (std::size_t k = 0; k < unfinished.size(); ++k) {
      const std::size_t i = unfinished[k];
      if (!nextHits[k] || starts[i] + nextHits[k]->distance > reach) continue;
      hits[i].push_back(*nextHits[k]);
      hits[i].back().distance += starts[i];
      starts[i] = hits[i].back().distance + kBehindHit;
      if (hits[i].size() < kMostHits && starts[i] < reach) further.push_back(i);
    }
    unfinished = std::move(further);
  }
  return hits;
}

SceneGround::SceneGround(const SceneProbe& probe, std::vector<std::uint16_t> classes)
    : probe_(probe), classes_(std::move(classes)), bounds_(probe.bounds()) {}

bool SceneGround::isGround(const SceneProbe::Hit& hit) const {
  if (std::fabs(hit.normal.z) < kSteepestGroundCosine) return false;
  if (!classes_.empty()) return std::ranges::find(classes_, hit.semantic) != classes_.end();
  const SemanticClass* const semanticClass = probe_.scene().ontology.find(hit.semantic);
  return semanticClass == nullptr || !semanticClass->thing;
}

std::optional<double> SceneGround::under(const Vec3d& position) const {
  if (bounds_.empty()) return std::nullopt;
  const double startHeight = bounds_.high.z + 1;
  const auto hits =
      probe_.all({{{position.x, position.y, startHeight}, kDown}}, startHeight - bounds_.low.z + 1).front();
  const SceneProbe::Hit* const ground = groundUnder(
      hits, position.z, [](const SceneProbe::Hit& hit) { return hit.position.z; },
      [&](const SceneProbe::Hit& hit) { return isGround(hit); });
  return ground == nullptr ? std::nullopt : std::optional(ground->position.z);
}

std::vector<std::vector<double>> SceneGround::around(const std::vector<Vec3d>& points, double reach) const {
  std::vector<SceneProbe::Ray> rays;
  rays.reserve(points.size());
  for (const Vec3d& point : points) rays.push_back({point - kDown * reach, kDown});
  std::vector<std::vector<double>> heights;
  heights.reserve(points.size());
  for (const std::vector<SceneProbe::Hit>& hits : probe_.all(rays, 2 * reach)) {
    heights.emplace_back();
    for (const SceneProbe::Hit& hit : hits) {
      if (isGround(hit)) heights.back().push_back(hit.position.z);
    }
  }
  return heights;
}

}  // namespace scanmill
