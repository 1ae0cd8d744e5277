#include "methods/ray_tracing/unobstructed.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "methods/ray_tracing/packet.h"
#include "methods/world/resolve.h"
#include "scene/embree.h"

namespace scanmill {

namespace {

constexpr double kSlack = 1e-3;  // m, margin around boxes for rounding

struct ThingContext {
  EmbreeContext embree = newEmbreeContext();
  const World* world;
  std::uint32_t thing;
};

// A box that contains a thing during the complete revolution, in the box's own axes.
struct ThingExtent {
  Pose boxFromOrigin;
  Box box;
  Vec3d middle;  // m, relative to the world's origin
  double radius = 0;
};

ThingExtent extentOf(const ThingBoxes& boxes, std::size_t thing, const World& world, double from, double duration) {
  const OrientedBox first = boxes.at(thing, from + duration / 2);
  ThingExtent extent;
  Pose originFromBox = first.worldFromBox;
  originFromBox.translation = originFromBox.translation - world.origin;
  extent.boxFromOrigin = inverse(originFromBox);
  const int steps = boxes.things()[thing].moves && duration > 0 ? 2 : 0;
  for (int i = 0; i <= steps; ++i) {
    const double time = steps == 0 ? from + duration / 2 : from + duration * i / steps;
    for (const Vec3d& corner : boxes.at(thing, time).corners()) {
      extent.box.add(extent.boxFromOrigin * (corner - world.origin));
    }
  }
  const Vec3d slack{kSlack, kSlack, kSlack};
  extent.box = {extent.box.low - slack, extent.box.high + slack};
  extent.middle = originFromBox * extent.box.center();
  extent.radius = length(extent.box.high - extent.box.low) / 2;
  return extent;
}

struct Interval {
  double enter, leave;  // distances along the ray at which it enters and leaves a box (m)
};

std::optional<Interval> crossing(const ThingExtent& extent, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d o = extent.boxFromOrigin * origin;
  const Vec3d d = toMatrix(extent.boxFromOrigin.rotation) * direction;
  Interval found{0, INFINITY};
  for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    const double low = extent.box.low.*axis - o.*axis;
    const double high = extent.box.high.*axis - o.*axis;
    if (d.*axis == 0) {
      if (low > 0 || high < 0) return std::nullopt;
      continue;
    }
    const double a = low / (d.*axis);
    const double b = high / (d.*axis);
    found.enter = std::max(found.enter, std::min(a, b));
    found.leave = std::min(found.leave, std::max(a, b));
  }
  return found.enter <= found.leave ? std::optional(found) : std::nullopt;
}

// Returns the half angle (rad) of a cone in the sensor's frame that contains all beams that may hit the thing during
// the revolution. The cone's axis is the direction to the thing's centre at the first pose. `offset`: largest distance
// of a beam's origin from the sensor's origin (m).
double angleOf(const ThingExtent& extent, const ShotFrame& frame, double offset) {
  const double radius = extent.radius + offset;
  double angle = 0;
  const Mat3 first = transposed(frame.rotation.front());
  const Vec3d towards = normalized(first * (extent.middle - frame.position.front()));
  for (const std::size_t step : {std::size_t{0}, frame.rotation.size() / 2, frame.rotation.size() - 1}) {
    const Vec3d toMiddle = extent.middle - frame.position[step];
    const double distance = length(toMiddle);
    if (distance <= radius * 1.01) return kPi;
    const Vec3d direction = normalized(transposed(frame.rotation[step]) * toMiddle);
    const double turned = std::atan2(length(cross(direction, towards)), dot(direction, towards));
    angle = std::max(angle, std::asin(radius / distance) + turned);
  }
  return angle;
}

// Returns the beam of the middle ring that is nearest to a direction. One ring is enough, because all rings of a column
// fire at almost the same time.
std::uint32_t nearestBeam(const BeamTable& beams, const Vec3d& direction) {
  const std::uint32_t first = beams.rings / 2 * beams.columns;
  std::uint32_t nearest = first;
  for (std::uint32_t beam = first; beam < first + beams.columns; ++beam) {
    if (dot(beams.direction[beam], direction) > dot(beams.direction[nearest], direction)) nearest = beam;
  }
  return nearest;
}

}  // namespace

// Rejects hits on all surfaces except the thing's, and hits on the thing at points that alpha cuts out.
void thingFilter(const RTCFilterFunctionNArguments* a) {
  const auto& context = *reinterpret_cast<const ThingContext*>(a->context);
  const World& world = *context.world;
  for (unsigned i = 0; i < a->N; ++i) {
    if (a->valid[i] == 0) continue;
    const unsigned geometry = RTCHitN_geomID(a->hit, a->N, i);
    const HitTriangle hit =
        hitTriangle(world, RTCHitN_instID(a->hit, a->N, i, 0), geometry, RTCHitN_primID(a->hit, a->N, i));
    const bool cut = geometry == 1 && transparentAt(world, *hit.block, hit.index, double{RTCHitN_u(a->hit, a->N, i)},
                                                    double{RTCHitN_v(a->hit, a->N, i)});
    if (instanceOf(hit) != context.thing || cut) a->valid[i] = 0;
  }
}

Unobstructed::View Unobstructed::of(std::size_t thing, const Shot& shot, const BeamGrid& grid) const {
  const BeamTable& beams = *shot.beams;
  const std::shared_ptr<const World> world = worlds_.near(
      shot.worldFromSensor.front().translation, farthestEnd(shot, grid.farthestOrigin()), shot.time, shot.duration);
  const ShotFrame frame = frameOf(shot, world->origin);
  const ThingExtent extent = extentOf(boxes_, thing, *world, shot.time, shot.duration);
  const Vec3d direction = normalized(transposed(frame.rotation.front()) * (extent.middle - frame.position.front()));
  const double angle = angleOf(extent, frame, grid.farthestOrigin()) + 1e-6;

  ThingContext context{.world = world.get(), .thing = boxes_.things()[thing].id};
  const auto hitsThing = [&](const Vec3d& o, const Vec3d& d, double from, double to, float revolutionFraction) {
    RTCRay ray{.org_x = static_cast<float>(o.x),
               .org_y = static_cast<float>(o.y),
               .org_z = static_cast<float>(o.z),
               .tnear = static_cast<float>(from),
               .dir_x = static_cast<float>(d.x),
               .dir_y = static_cast<float>(d.y),
               .dir_z = static_cast<float>(d.z),
               .time = revolutionFraction,
               .tfar = static_cast<float>(to),
               .mask = ~0u,
               .id = 0,
               .flags = 0};
    occludeOne(world->embree.get(), context.embree, ray);
    return ray.tfar < 0;
  };
  std::vector<std::pair<double, std::uint32_t>> firing;  // firing time (s) and beam
  grid.forBeamsNear(direction, angle, [&](std::uint32_t beam) {
    const std::uint32_t column = beam % beams.columns;
    const std::size_t step = frame.rotation.size() == 1 ? 0 : shot.stepOf(column);
    const Vec3d d = frame.rotation[step] * beams.direction[beam];
    Vec3d o = frame.position[step];
    if (!beams.origin.empty()) o += frame.rotation[step] * Vec3d(beams.origin[beam]);
    const std::optional<Interval> inside = crossing(extent, o, d);
    if (!inside || inside->enter > beams.maxRange) return false;
    const double time = beams.time.empty() ? beams.columnTime(column) : double{beams.time[beam]};
    const float revolutionFraction = firingFraction(beams, beam, world->revolution.duration);
    // A surface of the thing that is nearer than the minimum range blocks this beam.
    if (inside->enter < beams.minRange && hitsThing(o, d, inside->enter, beams.minRange, revolutionFraction))
      return false;
    const double from = std::max(inside->enter, beams.minRange);
    const double to = std::min(inside->leave, beams.maxRange);
    if (from <= to && hitsThing(o, d, from, to, revolutionFraction)) firing.emplace_back(time, beam);
    return false;
  });
  if (firing.empty()) return {0, nearestBeam(beams, direction)};
  const auto middle = firing.begin() + static_cast<std::ptrdiff_t>(firing.size() / 2);
  std::nth_element(firing.begin(), middle, firing.end());
  return {static_cast<std::uint32_t>(firing.size()), middle->second};
}

}  // namespace scanmill
