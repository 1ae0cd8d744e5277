#include "sense/sense.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "base/error.h"
#include "sense/echoes.h"
#include "sensors/footprint.h"

namespace scanmill {

namespace {

void checkHits(const Hits& hits, const Shot& shot, Channels needed) {
  const BeamTable& beams = *shot.beams;
  const std::size_t rays = hits.beamOfRay.empty() ? hits.size() : hits.beamOfRay.size();
  if (hits.rings != beams.rings || hits.columns != beams.columns || hits.rays() != rays) {
    throw Error(fmt::format("hits of {} x {} beams do not belong to a sensor of {} x {}", hits.rings, hits.columns,
                            beams.rings, beams.columns));
  }
  const Channels missing = needed.without(hits.channels);
  if (missing != Channels()) {
    throw Error(fmt::format("hits lack the channel {} that the effects and the columns asked for need",
                            channelNames(missing).front()));
  }
}

constexpr float kSmooth = 0.1f;  // largest roughness of a surface that reflects like a mirror
constexpr float kMetal = 0.5f;

Reason ofFaint(const Hits& hits, std::span<const Material> materials, std::uint32_t hit) {
  if (hit == kNoHit || hits.material.empty() || hits.material[hit] >= materials.size()) return Reason::TooFaint;
  const Material& material = materials[hits.material[hit]];
  if (material.transmission > 0 && hits.glassIsClear) return Reason::LostInGlass;
  return material.roughness <= kSmooth || material.metallic >= kMetal ? Reason::MirroredAway : Reason::TooFaint;
}

// Sets the reason of beams whose rays hit nothing reportable.
void fillEmpty(const Hits& hits, std::vector<std::uint8_t>& reasons) {
  const auto beamOf = [&](std::size_t ray) {
    return hits.beamOfRay.empty() ? static_cast<std::uint32_t>(ray) : hits.beamOfRay[ray];
  };
  for (std::size_t ray = 0; ray < hits.pathOfRay.size(); ++ray) {
    std::uint8_t& reason = reasons[beamOf(ray)];
    const bool blocked = hits.pathOfRay[ray] == RayPath::EgoVehicle && !hits.hit(ray);
    if (blocked && reason == 0) reason = static_cast<std::uint8_t>(Reason::BlockedByVehicle);
  }
  for (const std::uint32_t ray : hits.unresolved) {
    std::uint8_t& reason = reasons[beamOf(ray)];
    if (reason == 0) reason = static_cast<std::uint8_t>(Reason::GivenUp);
  }
  for (std::uint8_t& reason : reasons) {
    if (reason == 0) reason = static_cast<std::uint8_t>(Reason::NothingInRange);
  }
}

constexpr double kMoment = 0.01;  // s, interval over which velocities are computed if a shot has no duration

// Returns the displacement (m) of a point on a triangle between two meshes of an animation. The point keeps its
// barycentric coordinates.
Vec3d carried(const Mesh& now, const Mesh& next, std::uint32_t primitive, const Vec3d& place) {
  const auto corner = [&](const Mesh& mesh, int k) { return Vec3d(mesh.positions[mesh.triangles[primitive][k]]); };
  const Vec3d a = corner(now, 1) - corner(now, 0);
  const Vec3d b = corner(now, 2) - corner(now, 0);
  const Vec3d normal = cross(a, b);
  const double area = dot(normal, normal);
  if (!(area > 0)) return {};
  const Vec3d p = place - corner(now, 0);
  const double v = dot(cross(p, b), normal) / area;
  const double w = dot(cross(a, p), normal) / area;
  const auto moved = [&](int k) { return corner(next, k) - corner(now, k); };
  return moved(0) * (1 - v - w) + moved(1) * v + moved(2) * w;
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
  std::vector<float> power;
  const bool powered = std::any_of(effects.begin(), effects.end(),
                                   [&](const auto& effect) { return effect->powerOfRays(hits, materials, power); });
  returns.start(findEchoes(hits, power, pulseLength(shot.beams->pulse)), powered);
}

void sense(const Receiver& receiver, const Hits& hits, const Shot& shot, Returns& returns, Scan& scan) {
  const auto& [effects, materials, layout, motions] = receiver;
  checkHits(hits, shot, channelsFor(effects, layout.columns));
  detect(hits, shot, effects, materials, returns);
  if (layout.reasons) returns.tellReasons();
  for (const auto& effect : effects) effect->apply(hits, shot, materials, returns);
  gather(hits, shot, returns, layout, motions, scan);
  scan.reasonOfBeam.clear();
  if (layout.reasons) scan.reasonOfBeam = reasonsOf(hits, materials, returns);
}

std::vector<std::uint8_t> reasonsOf(const Hits& hits, std::span<const Material> materials, const Returns& returns) {
  if (!returns.tellsReasons()) throw Error("the table of returns has no reasons");
  std::vector<std::uint8_t> reasons(hits.size(), 0);
  std::vector<std::uint32_t> told(hits.size(), kNoHit);  // for each beam, the row that its reason comes from so far
  for (std::uint32_t row = 0; row < returns.size(); ++row) {
    const bool returned = returns.returned(row);
    const Reason lost = returns.lostTo(row);
    if (!returned && lost == Reason::None) continue;        // the row's ray missed
    if (!returned && returns.hit(row) == kNoHit) continue;  // a lost row that an effect had added, such as a raindrop
    const std::uint32_t beam = returns.beam(row);
    const std::uint32_t other = told[beam];
    const auto power = [&](std::uint32_t r) { return returns.power.empty() ? 0.0f : returns.power[r]; };
    if (other != kNoHit) {
      const bool otherReturned = returns.returned(other);
      if (otherReturned && !returned) continue;
      if (otherReturned && returns.range[other] <= returns.range[row]) continue;
      if (!otherReturned && !returned && power(other) >= power(row)) continue;
    }
    told[beam] = row;
    const Reason reason = returned                   ? returns.cause(row)
                          : lost == Reason::TooFaint ? ofFaint(hits, materials, returns.hit(row))
                                                     : lost;
    reasons[beam] = static_cast<std::uint8_t>(reason);
  }
  fillEmpty(hits, reasons);
  return reasons;
}

bool ThingMotions::areToldOf(const Scene& scene, const ScanLayout& layout) {
  if (!scene.moves()) return false;
  for (std::size_t c = 0; c < kColumnCount; ++c) {
    if (layout.columns.has(c) && tellsMotion(kColumns[c])) return true;
  }
  const std::vector<SemanticClass>& classes = scene.ontology.classes;
  return layout.columns.has(kLabel) &&
         std::any_of(classes.begin(), classes.end(), [](const SemanticClass& c) { return c.movingOf.has_value(); });
}

ThingMotions::ThingMotions(const Scene& scene, const Shot& shot)
    : scene_(scene), placed_(shot.placed), time_(shot.time), duration_(shot.duration), untilNext_(shot.untilNext) {
  for (const SemanticClass& c : scene.ontology.classes) {
    if (c.movingOf) movingClasses_.emplace(*c.movingOf, c.id);
  }
  const double duration = shot.duration > 0 ? shot.duration : kMoment;
  for (std::uint32_t index = 0; index < scene.instances.size(); ++index) {
    const Instance& i = scene.instances[index];
    // An instance with an animation counts as moving even if its pose does not change; its velocity is the velocity of
    // its pose.
    const RigidMotion* const given = placed_ == nullptr ? nullptr : placed_->find(index);
    const bool moves = given != nullptr ? given->moves() : i.movement != nullptr && i.movement->moves();
    if (i.animation == nullptr && !moves) continue;
    const Affine from = worldFromMeshAt(i, index, placed_.get(), shot.time);
    const Affine to = worldFromMeshAt(i, index, placed_.get(), shot.time + duration);
    const auto middle = [](const Vec3d& a, const Vec3d& b) { return (a + b) * 0.5; };
    const auto change = [duration](const Vec3d& a, const Vec3d& b) { return (b - a) * (1 / duration); };
    const Mat3 between{middle(from.linear.x, to.linear.x), middle(from.linear.y, to.linear.y),
                       middle(from.linear.z, to.linear.z)};
    const Mat3 changing{change(from.linear.x, to.linear.x), change(from.linear.y, to.linear.y),
                        change(from.linear.z, to.linear.z)};
    const Motion motion{middle(from.translation, to.translation), change(from.translation, to.translation),
                        changing * inverse(between)};
    for (std::uint32_t object = 1; object <= scene.meshes[i.mesh].objects; ++object) {
      const std::uint32_t thing = instanceId(i.firstInstanceId, object);
      things_.emplace(thing, motion);
      instances_.emplace(thing, index);
    }
  }
}

std::uint16_t ThingMotions::classOf(std::uint16_t semantic, std::uint32_t thing) const {
  if (!things_.contains(thing)) return semantic;
  const auto moving = movingClasses_.find(semantic);
  return moving == movingClasses_.end() ? semantic : moving->second;
}

Vec3d ThingMotions::velocity(std::uint32_t thing, const Vec3d& place) const {
  const auto found = things_.find(thing);
  if (found == things_.end()) return {};
  const Motion& m = found->second;
  return m.ofPivot + m.perMetre * (place - m.pivot);
}

Vec3d ThingMotions::flow(std::uint32_t thing, std::uint32_t primitive, const Vec3d& place, double time) const {
  const auto [first, last] = instances_.equal_range(thing);
  if (first == last) return {};
  if (std::next(first) == last) return flowOf(first->second, primitive, place, time);
  // Several entries of Scene::instances may share an id. Use the one whose triangle `primitive` is nearest to the
  // point.
  std::optional<std::uint32_t> nearest;
  double least = 0;
  for (auto own = first; own != last; ++own) {
    const Instance& instance = scene_.instances[own->second];
    const Mesh& mesh = scene_.meshes[instance.meshAt(time_ + duration_ / 2)];
    if (primitive >= mesh.triangles.size()) continue;
    const Affine worldFromMesh = worldFromMeshAt(instance, own->second, placed_.get(), time_ + time);
    const auto corner = [&](int k) { return worldFromMesh * Vec3d(mesh.positions[mesh.triangles[primitive][k]]); };
    const double off = length(place - (corner(0) + corner(1) + corner(2)) * (1.0 / 3));
    if (nearest && off >= least) continue;
    nearest = own->second;
    least = off;
  }
  return nearest ? flowOf(*nearest, primitive, place, time) : Vec3d{};
}

Vec3d ThingMotions::flowOf(std::uint32_t index, std::uint32_t primitive, const Vec3d& place, double time) const {
  const Instance& instance = scene_.instances[index];
  const Affine worldFromMesh = worldFromMeshAt(instance, index, placed_.get(), time_ + time);
  const Affine then = worldFromMeshAt(instance, index, placed_.get(), time_ + time + untilNext_);
  Vec3d inMesh = inverse(worldFromMesh) * place;
  const Mesh& now = scene_.meshes[instance.meshAt(time_ + duration_ / 2)];
  const Mesh& next = scene_.meshes[instance.meshAt(time_ + duration_ / 2 + untilNext_)];
  if (&now != &next && now.triangles.size() == next.triangles.size() && primitive < now.triangles.size()) {
    inMesh = inMesh + carried(now, next, primitive, inMesh);
  }
  return then * inMesh - place;
}

}  // namespace scanmill
