#include "methods/ray_tracing/unobstructed.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "methods/ray_tracing/packet.h"
#include "scene/embree.h"

namespace scanmill {

namespace {

constexpr double kBoxMargin = 1e-3;    // m, margin of boxes and ranges for rounding
constexpr double kAngleMargin = 1e-6;  // rad, margin of the cone around a thing for rounding

// The arguments of thingFilter(), which Embree passes to the filter.
struct ThingContext {
  EmbreeContext embree = newEmbreeContext();
  const World* world;
  std::uint32_t instanceId;  // instance id of the thing
};

// A box that contains a thing during the complete revolution, in the box's own axes.
struct ThingExtent {
  Pose boxFromOrigin;
  Box box;
  Vec3d middle;       // m, relative to the world's origin
  double radius = 0;  // m, radius of a ball around `middle` that contains the box
};

// Returns the extent of a thing during a shot. The box has the thing's axes at the
// middle of this time; for a moving thing, the box contains the thing's boxes at start, middle and end.
ThingExtent extentOf(const ThingBoxes& boxes, std::size_t thing, const World& world, const Shot& shot) {
  const double middleTime = shot.time + shot.duration / 2;
  std::vector<double> times{middleTime};
  const bool moves = boxes.things()[thing].moves || boxes.placement(thing, shot.placed.get()) != nullptr;
  if (moves && shot.duration > 0) times = {shot.time, middleTime, shot.time + shot.duration};
  ThingExtent extent;
  Pose originFromBox = boxes.at(thing, middleTime, shot.placed.get()).worldFromBox;
  originFromBox.translation = originFromBox.translation - world.origin;
  extent.boxFromOrigin = inverse(originFromBox);
  for (const double time : times) {
    for (const Vec3d& corner : boxes.at(thing, time, shot.placed.get()).corners()) {
      extent.box.add(extent.boxFromOrigin * (corner - world.origin));
    }
  }
  const Vec3d margin{kBoxMargin, kBoxMargin, kBoxMargin};
  extent.box = {extent.box.low - margin, extent.box.high + margin};
  extent.middle = originFromBox * extent.box.center();
  extent.radius = length(extent.box.high - extent.box.low) / 2;
  return extent;
}

struct Interval {
  double enter, leave;  // distances along a ray (m) at which the ray enters and leaves a box
};

// Returns the distances (m) between which a ray is in the thing's box; nothing if the ray misses the box.
std::optional<Interval> crossing(const ThingExtent& extent, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d o = extent.boxFromOrigin * origin;
  const Vec3d d = toMatrix(extent.boxFromOrigin.rotation) * direction;
  Interval inside{0, INFINITY};
  for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    const double low = extent.box.low.*axis - o.*axis;
    const double high = extent.box.high.*axis - o.*axis;
    if (d.*axis == 0) {
      if (low > 0 || high < 0) return std::nullopt;
      continue;
    }
    const double a = low / (d.*axis);
    const double b = high / (d.*axis);
    inside.enter = std::max(inside.enter, std::min(a, b));
    inside.leave = std::min(inside.leave, std::max(a, b));
  }
  return inside.enter <= inside.leave ? std::optional(inside) : std::nullopt;
}

// Returns the half angle (rad) of a cone in the sensor's frame that contains all beams that may hit the thing during
// the revolution; pi if the sensor is in the thing or close to it. `axis`: the cone's axis, towards the thing's centre
// from the sensor's first pose. `farthestOrigin`: largest distance (m) of a beam's origin from the sensor's origin.
double coneAngle(const ThingExtent& extent, const ShotFrame& frame, const Vec3d& axis, double farthestOrigin) {
  constexpr double kOutside = 1.01;  // radii; a sensor this near to the thing may see it in any direction
  const double radius = extent.radius + farthestOrigin;
  double angle = 0;
  for (const std::size_t step : {std::size_t{0}, frame.rotation.size() / 2, frame.rotation.size() - 1}) {
    const Vec3d toMiddle = extent.middle - frame.position[step];
    const double distance = length(toMiddle);
    if (distance <= radius * kOutside) return kPi;
    const Vec3d direction = normalized(transposed(frame.rotation[step]) * toMiddle);
    const double fromAxis = std::atan2(length(cross(direction, axis)), dot(direction, axis));
    angle = std::max(angle, std::asin(radius / distance) + fromAxis);
  }
  return angle;
}

// Returns the beam of the middle ring whose direction is nearest to `direction` (sensor's frame). Only the beam's
// column matters, because all rings of a column fire at almost the same time.
std::uint32_t nearestBeam(const BeamTable& beams, const Vec3d& direction) {
  const std::uint32_t first = beams.rings / 2 * beams.columns;
  std::uint32_t nearest = first;
  for (std::uint32_t beam = first; beam < first + beams.columns; ++beam) {
    if (dot(beams.direction[beam], direction) > dot(beams.direction[nearest], direction)) nearest = beam;
  }
  return nearest;
}

// Returns true if a surface of the context's thing is between the distances `near` and `far` (m) along a ray, which
// starts at `origin` (m, relative to the world's origin). `firedAt`: see HitTriangle::firedAt.
bool hitsThing(ThingContext& context, const Vec3d& origin, const Vec3d& direction, double near, double far,
               float firedAt) {
  RTCRay ray = newRay(origin, direction, static_cast<float>(near), static_cast<float>(far), firedAt).ray;
  occludeOne(context.world->embree.get(), context.embree, ray);
  return ray.tfar < 0;
}

}  // namespace

// Rejects hits on all surfaces except the thing's, and hits on the thing at points that alpha cuts out.
void thingFilter(const RTCFilterFunctionNArguments* arguments) {
  const auto& context = *reinterpret_cast<const ThingContext*>(arguments->context);
  const World& world = *context.world;
  RTCHitN* const hits = arguments->hit;
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const unsigned geometry = RTCHitN_geomID(hits, n, i);
    const HitTriangle hit = hitTriangle(world, RTCHitN_instID(hits, n, i, 0), geometry, RTCHitN_primID(hits, n, i));
    const bool isAlphaTested = geometry == 1;  // see TriangleBlock
    const bool isTransparent =
        isAlphaTested &&
        transparentAt(world, *hit.block, hit.index, double{RTCHitN_u(hits, n, i)}, double{RTCHitN_v(hits, n, i)});
    if (instanceOf(hit) != context.instanceId || isTransparent) arguments->valid[i] = 0;
  }
}

Unobstructed::Sight Unobstructed::sightOf(const Shot& shot, const BeamGrid& grid, const Hits* met,
                                          std::uint32_t raysPerBeam) const {
  const std::shared_ptr<const World> world =
      worlds_.near(shot.worldFromSensor.front().translation, farthestEnd(shot, grid.farthestOrigin()), shot.time,
                   shot.duration, shot.placed);
  return {shot, grid, world, frameOf(shot, world->origin), met, raysPerBeam};
}

Unobstructed::View Unobstructed::viewOf(std::size_t thing, const Sight& sight) const {
  const Shot& shot = sight.shot;
  const ShotFrame& frame = sight.frame;
  const World* const world = sight.world.get();
  const Hits* const met = sight.met;
  const BeamTable& beams = *shot.beams;
  const ThingExtent extent = extentOf(boxes_, thing, *world, shot);
  const Vec3d axis = normalized(transposed(frame.rotation.front()) * (extent.middle - frame.position.front()));
  const double angle = coneAngle(extent, frame, axis, sight.grid.farthestOrigin()) + kAngleMargin;
  const double leastCosine = angle < kPi ? std::cos(angle) : -2;

  ThingContext context{.world = world, .instanceId = boxes_.things()[thing].id};
  // Returns true if the beam would hit the thing within the sensor's range.
  const auto seesThing = [&](std::uint32_t beam) {
    if (dot(beams.direction[beam], axis) < leastCosine) return false;
    const std::uint32_t step = frame.step[beam % beams.columns];
    const Vec3d direction = frame.rotation[step] * beams.direction[beam];
    const Vec3d origin = frame.position[step] + frame.rotation[step] * beams.originOf(beam);
    const std::optional<Interval> inside = crossing(extent, origin, direction);
    if (!inside || inside->enter > beams.maxRange) return false;
    double near = inside->enter;
    const std::size_t ray = std::size_t{beam} * sight.raysPerBeam;
    if (met != nullptr && met->hit(ray) && (met->pathOfRay.empty() || met->pathOfRay[ray] == RayPath::Direct)) {
      if (met->instance[ray] == context.instanceId) return true;
      near = std::max(near, met->range[ray] - kBoxMargin);  // up to there the beam met nothing
      if (near > inside->leave) return false;
    }
    const float firedAt = firingFraction(beams, beam, world->revolution.duration);
    // A surface of the thing that is nearer than the minimum range blocks this beam.
    if (near < beams.minRange && hitsThing(context, origin, direction, near, beams.minRange, firedAt)) return false;
    near = std::max(near, beams.minRange);
    const double far = std::min(inside->leave, beams.maxRange);
    return near <= far && hitsThing(context, origin, direction, near, far, firedAt);
  };
  std::vector<std::pair<double, std::uint32_t>> firings;  // firing time (s) and beam
  sight.grid.forBeamsNear(axis, angle, [&](std::uint32_t beam) {
    if (seesThing(beam)) {
      firings.emplace_back(beams.time.empty() ? beams.columnTime(beam % beams.columns) : double{beams.time[beam]},
                           beam);
    }
    return false;  // continue with the next beam
  });
  if (firings.empty()) return {0, nearestBeam(beams, axis)};
  const auto middle = firings.begin() + static_cast<std::ptrdiff_t>(firings.size() / 2);
  std::nth_element(firings.begin(), middle, firings.end());
  return {static_cast<std::uint32_t>(firings.size()), middle->second};
}

}  // namespace scanmill
