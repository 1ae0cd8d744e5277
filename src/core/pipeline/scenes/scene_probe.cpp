#include "pipeline/scenes/scene_probe.h"

#include <algorithm>
#include <cmath>

#include "scene/surface_heights.h"

namespace scanmill {
namespace {

constexpr double kBehindHit = 1e-3;  // m, distance behind a hit at which the next ray starts
constexpr std::size_t kMostHits = 100;
// Distance (m) along a ray after which all() moves the anchor, the point that the method takes for the sensor's
// position. Rare moves save work, since a method may build a hierarchy for each anchor. Ray tracing orders coplanar
// surfaces reliably up to 64 m from the anchor (kCoplanarCorners).
constexpr double kAnchorDistance = 48;
constexpr double kBoundsMargin = 1;        // m, around the scene's bounds
constexpr double kNearGroundHeight = 1.5;  // m, largest height difference of the ground that near() finds
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

std::vector<SceneProbe::Hit> SceneProbe::all(const Ray& ray, double reach) const {
  std::vector<Hit> hits;
  double start = 0;   // distance along the ray (m) from which the next hit is searched
  double anchor = 0;  // distance along the ray (m) of the anchor, which the method takes for the sensor's position
  while (hits.size() < kMostHits && start < reach) {
    if (start - anchor > kAnchorDistance) anchor = start;
    const std::vector<Ray> remaining{{ray.from + ray.direction * start, ray.direction}};
    std::optional<Hit> hit = first(remaining, reach - start, ray.from + ray.direction * anchor).front();
    if (!hit) break;
    hit->distance += start;
    start = hit->distance + kBehindHit;
    hits.push_back(*hit);
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
  const auto hits = probe_.all({{position.x, position.y, startHeight}, kDown}, startHeight - bounds_.low.z + 1);
  const SceneProbe::Hit* const ground = groundUnder(
      hits, position.z, [](const SceneProbe::Hit& hit) { return hit.position.z; },
      [&](const SceneProbe::Hit& hit) { return isGround(hit); });
  return ground == nullptr ? std::nullopt : std::optional(ground->position.z);
}

std::optional<double> SceneGround::near(const Vec3d& position) const {
  std::optional<double> nearest;
  for (const SceneProbe::Hit& hit : probe_.all({position - kDown * kNearGroundHeight, kDown}, 2 * kNearGroundHeight)) {
    if (isGround(hit) && (!nearest || std::fabs(hit.position.z - position.z) < std::fabs(*nearest - position.z))) {
      nearest = hit.position.z;
    }
  }
  return nearest;
}

}  // namespace scanmill
