#include "sense/thing_motions.h"

#include <algorithm>
#include <iterator>
#include <optional>

namespace scanmill {

namespace {

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
