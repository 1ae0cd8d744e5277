#include "sense/sense.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "base/error.h"
#include "methods/interface/light_paths.h"
#include "sensors/footprint.h"

namespace scanmill {

namespace {

// Throws Error if the hits do not have the beams of the shot's sensor, or lack one of the channels `needed`.
void checkHits(const Hits& hits, const Shot& shot, Channels needed) {
  const BeamTable& beams = *shot.beams;
  const std::size_t rays = hits.beamOfRay.empty() ? hits.size() : hits.beamOfRay.size();
  if (hits.rings != beams.rings || hits.columns != beams.columns || hits.rays() != rays) {
    throw Error("hits of {} x {} beams do not belong to a sensor of {} x {}", hits.rings, hits.columns, beams.rings,
                beams.columns);
  }
  const Channels missing = needed.without(hits.channels);
  if (missing != Channels()) {
    throw Error("hits lack the channel {} that the effects and the columns asked for need",
                channelNames(missing).front());
  }
}

constexpr float kMetalness = 0.5f;  // least metallicity of a surface that counts as metal

// Returns the reason of an echo that is too faint, by the material: LostInGlass, MirroredAway or else TooFaint.
Reason reasonOfFaint(const Hits& hits, std::span<const Material> materials, std::uint32_t hit) {
  if (hit == kNoHit || hits.material.empty() || hits.material[hit] >= materials.size()) return Reason::TooFaint;
  const Material& material = materials[hits.material[hit]];
  if (material.transmission > 0 && hits.glassIsClear) return Reason::LostInGlass;
  return material.roughness <= kMirrorRoughness || material.metallic >= kMetalness ? Reason::MirroredAway
                                                                                   : Reason::TooFaint;
}

// Sets the reason of each beam that has none so far, because its rays hit nothing reportable.
void setReasonsOfEmptyBeams(const Hits& hits, std::vector<std::uint8_t>& reasons) {
  const auto setIfNone = [&](std::size_t ray, Reason reason) {
    std::uint8_t& reasonOfBeam = reasons[hits.beamOfRay.empty() ? ray : hits.beamOfRay[ray]];
    if (reasonOfBeam == 0) reasonOfBeam = static_cast<std::uint8_t>(reason);
  };
  for (std::size_t ray = 0; ray < hits.pathOfRay.size(); ++ray) {
    if (hits.pathOfRay[ray] == RayPath::EgoVehicle && !hits.hit(ray)) setIfNone(ray, Reason::BlockedByVehicle);
  }
  for (const std::uint32_t ray : hits.unresolved) setIfNone(ray, Reason::GivenUp);
  std::ranges::replace(reasons, std::uint8_t{0}, static_cast<std::uint8_t>(Reason::NothingInRange));
}

// Returns true if a beam's reason comes from `row` rather than from `other`. A row with a return precedes a lost row;
// of two returns the nearer one precedes, of two lost rows the one with more power.
bool givesReasonBefore(const Returns& returns, std::uint32_t row, std::uint32_t other) {
  if (returns.returned(row) != returns.returned(other)) return returns.returned(row);
  if (returns.returned(row)) return returns.range[row] < returns.range[other];
  return !returns.power.empty() && returns.power[row] > returns.power[other];
}

constexpr double kVelocityInterval = 0.01;  // s, interval over which velocities are computed if a shot has no duration

// Returns the displacement (m) of a point on a triangle between two meshes of an animation. The point keeps its
// barycentric coordinates.
Vec3d displacementOnTriangle(const Mesh& now, const Mesh& next, std::uint32_t primitive, const Vec3d& point) {
  const auto corner = [&](const Mesh& mesh, int k) { return Vec3d(mesh.positions[mesh.triangles[primitive][k]]); };
  const Vec3d edge1 = corner(now, 1) - corner(now, 0);
  const Vec3d edge2 = corner(now, 2) - corner(now, 0);
  const Vec3d normal = cross(edge1, edge2);
  const double areaSquared = dot(normal, normal);  // m^4, of the parallelogram that the edges span
  if (!(areaSquared > 0)) return {};
  const Vec3d p = point - corner(now, 0);
  const double weight1 = dot(cross(p, edge2), normal) / areaSquared;
  const double weight2 = dot(cross(edge1, p), normal) / areaSquared;
  const auto displacement = [&](int k) { return corner(next, k) - corner(now, k); };
  return displacement(0) * (1 - weight1 - weight2) + displacement(1) * weight1 + displacement(2) * weight2;
}

}  // namespace

Channels channelsFor(EffectList effects, ColumnSet columns) {
  Channels channels = Channels(Channel::Range) | columns.channels();
  for (const auto& effect : effects) channels |= effect->reads();
  return channels;
}

void detect(const Hits& hits, const Shot& shot, EffectList effects, std::span<const Material> materials,
            Returns& returns) {
  returns.falloff = {};
  returns.threshold = 0;
  for (const auto& effect : effects) {
    returns.falloff = effect->falloff().value_or(returns.falloff);
    if (effect->threshold() > 0) returns.threshold = effect->threshold();
  }
  if (hits.beamOfRay.empty()) return returns.start(hits);
  std::vector<float> power;  // by ray, from the first effect that computes it
  const bool hasPower =
      std::ranges::any_of(effects, [&](const auto& effect) { return effect->powerOfRays(hits, materials, power); });
  returns.start(findEchoes(hits, power, pulseLength(shot.beams->pulse)), hasPower);
}

void sense(const Receiver& receiver, const Hits& hits, const Shot& shot, Returns& returns, Scan& scan) {
  const auto& [effects, materials, layout, motions] = receiver;
  checkHits(hits, shot, channelsFor(effects, layout.columns));
  detect(hits, shot, effects, materials, returns);
  if (layout.reasons) returns.recordReasons();
  for (const auto& effect : effects) effect->apply(hits, shot, materials, returns);
  gather(hits, shot, returns, layout, motions, scan);
  scan.reasonOfBeam.clear();
  if (layout.reasons) scan.reasonOfBeam = reasonsOf(hits, materials, returns);
}

std::vector<std::uint8_t> reasonsOf(const Hits& hits, std::span<const Material> materials, const Returns& returns) {
  if (!returns.recordsReasons()) throw Error("the table of returns has no reasons");
  std::vector<std::uint8_t> reasons(hits.size(), 0);
  std::vector<std::uint32_t> rowOfReason(hits.size(), kNoHit);  // the row that each beam's reason comes from so far
  for (std::uint32_t row = 0; row < returns.size(); ++row) {
    const bool returned = returns.returned(row);
    const Reason lost = returns.reasonLost(row);
    if (!returned && lost == Reason::None) continue;        // the row's ray missed
    if (!returned && returns.hit(row) == kNoHit) continue;  // a lost row that an effect had added, such as a raindrop
    const std::uint32_t beam = returns.beam(row);
    if (rowOfReason[beam] != kNoHit && !givesReasonBefore(returns, row, rowOfReason[beam])) continue;
    rowOfReason[beam] = row;
    const Reason reason = returned                   ? returns.cause(row)
                          : lost == Reason::TooFaint ? reasonOfFaint(hits, materials, returns.hit(row))
                                                     : lost;
    reasons[beam] = static_cast<std::uint8_t>(reason);
  }
  setReasonsOfEmptyBeams(hits, reasons);
  return reasons;
}

bool InstanceMotions::areNeeded(const Scene& scene, const ScanLayout& layout) {
  if (!scene.moves()) return false;
  for (std::size_t c = 0; c < kColumnCount; ++c) {
    if (layout.columns.has(c) && dependsOnMotion(kColumns[c])) return true;
  }
  const std::vector<SemanticClass>& classes = scene.ontology.classes;
  return layout.columns.has(kLabel) &&
         std::ranges::any_of(classes, [](const SemanticClass& c) { return c.movingOf.has_value(); });
}

InstanceMotions::InstanceMotions(const Scene& scene, const Shot& shot)
    : scene_(scene), placed_(shot.placed), time_(shot.time), duration_(shot.duration), untilNext_(shot.untilNext) {
  for (const SemanticClass& c : scene.ontology.classes) {
    if (c.movingOf) movingClasses_.emplace(*c.movingOf, c.id);
  }
  const double duration = shot.duration > 0 ? shot.duration : kVelocityInterval;
  for (std::uint32_t index = 0; index < scene.instances.size(); ++index) {
    const Instance& instance = scene.instances[index];
    // An instance with an animation counts as moving even if its pose does not change. Its velocity is the velocity of
    // its pose.
    const RigidMotion* const placedMotion = placed_ == nullptr ? nullptr : placed_->find(index);
    const bool poseMoves =
        placedMotion != nullptr ? placedMotion->moves() : instance.movement != nullptr && instance.movement->moves();
    if (instance.animation == nullptr && !poseMoves) continue;
    const Affine start = worldFromMeshAt(instance, index, placed_.get(), shot.time);
    const Affine end = worldFromMeshAt(instance, index, placed_.get(), shot.time + duration);
    const auto mean = [](const Vec3d& a, const Vec3d& b) { return (a + b) * 0.5; };
    const auto rate = [duration](const Vec3d& a, const Vec3d& b) { return (b - a) * (1 / duration); };
    const auto byColumn = [&](const auto& f) {
      return Mat3{f(start.linear.x, end.linear.x), f(start.linear.y, end.linear.y), f(start.linear.z, end.linear.z)};
    };
    const Motion motion{.pivot = mean(start.translation, end.translation),
                        .velocityOfPivot = rate(start.translation, end.translation),
                        .velocityPerMetre = byColumn(rate) * inverse(byColumn(mean))};
    for (std::uint32_t object = 1; object <= scene.meshes[instance.mesh].objects; ++object) {
      const std::uint32_t id = instanceId(instance.firstInstanceId, object);
      motionOf_.emplace(id, motion);
      instances_.emplace(id, index);
    }
  }
}

std::uint16_t InstanceMotions::classOf(std::uint16_t semantic, std::uint32_t instanceId) const {
  if (!motionOf_.contains(instanceId)) return semantic;
  const auto moving = movingClasses_.find(semantic);
  return moving == movingClasses_.end() ? semantic : moving->second;
}

Vec3d InstanceMotions::velocity(std::uint32_t instanceId, const Vec3d& point) const {
  const auto motion = motionOf_.find(instanceId);
  if (motion == motionOf_.end()) return {};
  const auto& [pivot, velocityOfPivot, velocityPerMetre] = motion->second;
  return velocityOfPivot + velocityPerMetre * (point - pivot);
}

Vec3d InstanceMotions::flow(std::uint32_t instanceId, std::uint32_t primitive, const Vec3d& point, double time) const {
  const auto [first, last] = instances_.equal_range(instanceId);
  if (first == last) return {};
  if (std::next(first) == last) return flowOf(first->second, primitive, point, time);
  // Several entries of Scene::instances may share an id: take the entry whose triangle `primitive` is nearest to the
  // point.
  std::optional<std::uint32_t> nearest;
  double nearestDistance = 0;
  for (auto candidate = first; candidate != last; ++candidate) {
    const Instance& instance = scene_.instances[candidate->second];
    const Mesh& mesh = scene_.meshes[instance.meshAt(time_ + duration_ / 2)];
    if (primitive >= mesh.triangles.size()) continue;
    const Affine worldFromMesh = worldFromMeshAt(instance, candidate->second, placed_.get(), time_ + time);
    const auto corner = [&](int k) { return worldFromMesh * Vec3d(mesh.positions[mesh.triangles[primitive][k]]); };
    const double distance = length(point - (corner(0) + corner(1) + corner(2)) * (1.0 / 3));
    if (nearest && distance >= nearestDistance) continue;
    nearest = candidate->second;
    nearestDistance = distance;
  }
  return nearest ? flowOf(*nearest, primitive, point, time) : Vec3d{};
}

Vec3d InstanceMotions::flowOf(std::uint32_t index, std::uint32_t primitive, const Vec3d& point, double time) const {
  const Instance& instance = scene_.instances[index];
  const Affine worldFromMesh = worldFromMeshAt(instance, index, placed_.get(), time_ + time);
  const Affine nextWorldFromMesh = worldFromMeshAt(instance, index, placed_.get(), time_ + time + untilNext_);
  Vec3d inMesh = inverse(worldFromMesh) * point;
  const Mesh& now = scene_.meshes[instance.meshAt(time_ + duration_ / 2)];
  const Mesh& next = scene_.meshes[instance.meshAt(time_ + duration_ / 2 + untilNext_)];
  if (&now != &next && now.triangles.size() == next.triangles.size() && primitive < now.triangles.size()) {
    inMesh = inMesh + displacementOnTriangle(now, next, primitive, inMesh);
  }
  return nextWorldFromMesh * inMesh - point;
}

}  // namespace scanmill
