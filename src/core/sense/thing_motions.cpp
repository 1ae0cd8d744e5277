#include "sense/thing_motions.h"

#include <algorithm>

namespace scanmill {

namespace {

constexpr double kMoment = 0.01;  // s, of a revolution in which all stands still

}  // namespace

bool ThingMotions::areToldOf(const Scene& scene, const ScanLayout& layout) {
  if (!scene.moves()) return false;
  for (std::size_t c = 0; c < kColumnCount; ++c) {
    if (layout.columns.has(c) && kColumns[c].name.starts_with("velocity_")) return true;
  }
  const std::vector<SemanticClass>& classes = scene.ontology.classes;
  return layout.columns.has(kLabel) &&
         std::any_of(classes.begin(), classes.end(), [](const SemanticClass& c) { return c.movingOf.has_value(); });
}

ThingMotions::ThingMotions(const Scene& scene, const Shot& shot) {
  for (const SemanticClass& c : scene.ontology.classes) {
    if (c.movingOf) movingClasses_.emplace(*c.movingOf, c.id);
  }
  const double duration = shot.duration > 0 ? shot.duration : kMoment;
  for (const Instance& i : scene.instances) {
    // What an animation alone moves has a class that moves, and the velocity of its place.
    if (i.animation == nullptr && (i.movement == nullptr || !i.movement->moves())) continue;
    const Affine from = i.worldFromMeshAt(shot.time);
    const Affine to = i.worldFromMeshAt(shot.time + duration);
    const auto middle = [](const Vec3d& a, const Vec3d& b) { return (a + b) * 0.5; };
    const auto change = [duration](const Vec3d& a, const Vec3d& b) { return (b - a) * (1 / duration); };
    const Mat3 between{middle(from.linear.x, to.linear.x), middle(from.linear.y, to.linear.y),
                       middle(from.linear.z, to.linear.z)};
    const Mat3 changing{change(from.linear.x, to.linear.x), change(from.linear.y, to.linear.y),
                        change(from.linear.z, to.linear.z)};
    const Motion motion{middle(from.translation, to.translation), change(from.translation, to.translation),
                        changing * inverse(between)};
    for (std::uint32_t object = 1; object <= scene.meshes[i.mesh].objects; ++object) {
      things_.emplace(instanceId(i.firstInstanceId, object), motion);
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

}  // namespace scanmill
