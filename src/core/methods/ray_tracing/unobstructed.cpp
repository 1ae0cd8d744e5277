#include "methods/ray_tracing/unobstructed.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <span>
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
  const TriangleBlock* block;  // what is traced; null: all of the world
  std::uint32_t id;            // of the thing: its instance id in the world, its number in `block`
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

// A part of a beam's path that a thing may cross. Origin and direction are relative to the world's origin.
struct Stretch {
  std::uint32_t beam;
  Vec3d origin, direction;
  double near, far;  // m
  double leave;      // m, where the ray leaves the thing's box, or the sensor's range
};

// Returns for up to sixteen stretches, as bits, whether the context's thing crosses them. `placed`: where the context's
// block is; null: all of the world is traced.
std::uint32_t crossed(ThingContext& context, const PlacedBlock* placed, const BeamTable& beams,
                      std::span<const Stretch> stretches) {
  Affine meshFromOrigin;
  if (placed != nullptr) meshFromOrigin = inverse(placed->originFromMesh);
  RTCRay16 rays;
  alignas(64) int valid[kPacket];
  for (std::size_t i = 0; i < kPacket; ++i) {
    valid[i] = i < stretches.size() ? -1 : 0;
    const Stretch& s = stretches[valid[i] != 0 ? i : 0];
    rays.time[i] = firingFraction(beams, s.beam, context.world->revolution.duration);
    if (placed != nullptr && placed->moves) meshFromOrigin = inverse(placed->at(double{rays.time[i]}));
    const Vec3d origin = placed == nullptr ? s.origin : meshFromOrigin * s.origin;
    const Vec3d direction = placed == nullptr ? s.direction : meshFromOrigin.linear * s.direction;
    rays.org_x[i] = static_cast<float>(origin.x);
    rays.org_y[i] = static_cast<float>(origin.y);
    rays.org_z[i] = static_cast<float>(origin.z);
    rays.dir_x[i] = nonTiny(direction.x);
    rays.dir_y[i] = nonTiny(direction.y);
    rays.dir_z[i] = nonTiny(direction.z);
    rays.tnear[i] = static_cast<float>(s.near);
    rays.tfar[i] = static_cast<float>(s.far);
    rays.mask[i] = ~0u;
    rays.id[i] = static_cast<unsigned>(i);
    rays.flags[i] = 0;
  }
  occludePacket(placed == nullptr ? context.world->embree.get() : placed->hierarchy, context.embree, valid, rays);
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < stretches.size(); ++i) bits |= rays.tfar[i] < 0 ? 1u << i : 0;
  return bits;
}

// Keeps the stretches that a thing crosses if `crosses` is true, else those that it does not cross. `blocks`: the
// thing's blocks, each with the thing's number in it; empty: all of the world is traced for the instance `id`.
void keep(bool crosses, std::uint32_t id, const std::vector<Unobstructed::NumberedBlock>& blocks, const World& world,
          const BeamTable& beams, std::vector<Stretch>& stretches) {
  std::size_t kept = 0;
  for (std::size_t first = 0; first < stretches.size(); first += kPacket) {
    const std::span packet(&stretches[first], std::min<std::size_t>(kPacket, stretches.size() - first));
    std::uint32_t bits = 0;
    if (blocks.empty()) {
      ThingContext context{.world = &world, .block = nullptr, .id = id};
      bits = crossed(context, nullptr, beams, packet);
    }
    for (const auto& [placed, number] : blocks) {
      ThingContext context{.world = &world, .block = placed->block, .id = number};
      bits |= crossed(context, placed, beams, packet);
    }
    for (std::size_t i = 0; i < packet.size(); ++i) {
      if (((bits >> i & 1) != 0) == crosses) stretches[kept++] = packet[i];
    }
  }
  stretches.resize(kept);
}

}  // namespace

// Rejects hits on all surfaces except the thing's, and hits on the thing at points that alpha cuts out.
void thingFilter(const RTCFilterFunctionNArguments* arguments) {
  const auto& context = *reinterpret_cast<const ThingContext*>(arguments->context);
  RTCHitN* const hits = arguments->hit;
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const unsigned geometry = RTCHitN_geomID(hits, n, i);
    const unsigned primitive = RTCHitN_primID(hits, n, i);
    HitTriangle hit{.block = context.block};
    std::uint32_t id = 0;
    if (context.block != nullptr) {
      hit.index = context.block->indexOf(geometry, primitive);
      id = context.block->surfaceOf(hit.index).instance;
    } else {
      hit = hitTriangle(*context.world, RTCHitN_instID(hits, n, i, 0), geometry, primitive);
      id = instanceOf(hit);
    }
    const bool isAlphaTested = geometry == 1;  // see TriangleBlock
    const bool isTransparent =
        isAlphaTested && transparentAt(*context.world, *hit.block, hit.index, double{RTCHitN_u(hits, n, i)},
                                       double{RTCHitN_v(hits, n, i)});
    if (id != context.id || isTransparent) arguments->valid[i] = 0;
  }
}

Unobstructed::Sight Unobstructed::sightOf(const Shot& shot, const BeamGrid& grid, const Hits* met,
                                          std::uint32_t raysPerBeam) const {
  const std::shared_ptr<const World> world =
      worlds_.near(shot.worldFromSensor.front().translation, farthestEnd(shot, grid.farthestOrigin()), shot.time,
                   shot.duration, shot.placed);
  Sight sight{shot, grid, world, frameOf(shot, world->origin), met, raysPerBeam, {}};
  if (!world->baked.triangles.empty()) return sight;
  for (const PlacedBlock& placed : world->placed) {
    std::set<std::uint32_t> numbers;
    for (const HitSurface& surface : placed.block->surfaces) {
      if (surface.instance != 0) numbers.insert(surface.instance);
    }
    for (const std::uint32_t n : numbers) sight.blocks[instanceId(placed.firstInstanceId, n)].push_back({&placed, n});
  }
  return sight;
}

Unobstructed::View Unobstructed::viewOf(std::size_t thing, const Sight& sight) const {
  const Shot& shot = sight.shot;
  const ShotFrame& frame = sight.frame;
  const Hits* const met = sight.met;
  const BeamTable& beams = *shot.beams;
  const ThingExtent extent = extentOf(boxes_, thing, *sight.world, shot);
  const Vec3d axis = normalized(transposed(frame.rotation.front()) * (extent.middle - frame.position.front()));
  const double angle = coneAngle(extent, frame, axis, sight.grid.farthestOrigin()) + kAngleMargin;
  const double leastCosine = angle < kPi ? std::cos(angle) : -2;

  const std::uint32_t id = boxes_.things()[thing].id;
  std::vector<std::pair<double, std::uint32_t>> firings;  // firing time (s) and beam, of beams that see the thing
  const auto see = [&](std::uint32_t beam) {
    firings.emplace_back(beams.time.empty() ? beams.columnTime(beam % beams.columns) : double{beams.time[beam]}, beam);
  };
  std::vector<Stretch> near;  // up to the minimum range, where a surface of the thing would block the beam
  std::vector<Stretch> far;
  sight.grid.forBeamsNear(axis, angle, [&](std::uint32_t beam) {
    constexpr bool kContinue = false;  // with the next beam
    if (dot(beams.direction[beam], axis) < leastCosine) return kContinue;
    const std::uint32_t step = frame.step[beam % beams.columns];
    const Vec3d direction = frame.rotation[step] * beams.direction[beam];
    const Vec3d origin = frame.position[step] + frame.rotation[step] * beams.originOf(beam);
    std::optional<Interval> inside = crossing(extent, origin, direction);
    if (!inside || inside->enter > beams.maxRange) return kContinue;
    const std::size_t ray = std::size_t{beam} * sight.raysPerBeam;
    if (met != nullptr && met->hit(ray) && (met->pathOfRay.empty() || met->pathOfRay[ray] == RayPath::Direct)) {
      if (met->instance[ray] == id) {
        see(beam);
        return kContinue;
      }
      inside->enter = std::max(inside->enter, met->range[ray] - kBoxMargin);  // up to there the beam met nothing
      if (inside->enter > inside->leave) return kContinue;
    }
    const double leave = std::min(inside->leave, beams.maxRange);
    if (leave < std::max(inside->enter, beams.minRange)) return kContinue;
    if (inside->enter < beams.minRange) {
      near.push_back({beam, origin, direction, inside->enter, beams.minRange, leave});
    } else {
      far.push_back({beam, origin, direction, inside->enter, leave, leave});
    }
    return kContinue;
  });
  const std::vector<NumberedBlock> none;
  const auto found = sight.blocks.find(id);
  const std::vector<NumberedBlock>& blocks = found == sight.blocks.end() ? none : found->second;
  keep(false, id, blocks, *sight.world, beams, near);
  for (Stretch& s : near) {
    s.near = beams.minRange;
    s.far = s.leave;
  }
  far.insert(far.end(), near.begin(), near.end());
  keep(true, id, blocks, *sight.world, beams, far);
  for (const Stretch& s : far) see(s.beam);
  if (firings.empty()) return {0, nearestBeam(beams, axis)};
  const auto middle = firings.begin() + static_cast<std::ptrdiff_t>(firings.size() / 2);
  std::nth_element(firings.begin(), middle, firings.end());
  return {static_cast<std::uint32_t>(firings.size()), middle->second};
}

}  // namespace scanmill
