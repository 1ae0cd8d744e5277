// Computes exact hits: intersects every beam with every triangle that the beam might hit, in double precision.
//
// Embree only finds candidate triangles. Its boxes and rays are float32, so the boxes are enlarged by the rounding
// errors. Which triangle is hit, and where, is computed in double from the corners in the mesh.

#include "evaluate/exact/exact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <tuple>
#include <utility>

#include "base/parallel.h"
#include "base/recently_used.h"
#include "base/vec.h"
#include "methods/ray_tracing/filter.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "scene/embree.h"

namespace scanmill {

namespace {

constexpr double kGrid = 1024;            // spacing of possible world origins (m), on a grid around the scene's centre
constexpr std::size_t kCachedWorlds = 2;  // number of cached worlds; 2 for a path midway between two origins
constexpr double kRounding = 0x1p-24;     // relative rounding error of a float32
constexpr double kAlongAnAxis = 1e-12;    // smaller direction components become zero for Embree, see embreeComponent()

// Two surfaces count as coplanar if their distance along the normal is at most kCoplanar x range + kFloor (m), the same
// rule as in ray tracing with the sensor at the world's origin. kFloor is the rounding error of float32 corners
// near the sensor.
const double kFloor = double{coplanarFloor(0)};

// Returns the maximum range (m) of surfaces that may be coplanar with the nearest surface, which is at `range` (m).
double coplanarReach(double range) {
  return range + (range * double{kReach} + kFloor);
}

struct TriangleHit {
  double range = 0;     // distance from the beam's origin (m); 0: the beam does not hit the triangle
  double u = 0, v = 0;  // barycentric coordinates of the second and third corner
};

// A beam that is intersected with triangles in double precision (Woop, Benthin, Wald, "Watertight Ray/Triangle
// Intersection", JCGT 2(1), 2013). The test whether the beam passes left or right of an edge gives exactly the same
// result for both triangles at the edge, so no beam passes between them. Coordinates are permuted and sheared so that
// the beam runs along the z axis.
class ShearedBeam {
 public:
  ShearedBeam(const Vec3d& origin, const Vec3d& direction) : origin_(origin) {
    // The new z axis is the axis along which the direction's component is largest.
    const Vec3d size{std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)};
    z_ = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    const double along = component(direction, z_);
    if (along < 0) std::swap(x_, y_);  // preserves the winding order
    shearX_ = component(direction, x_) / along;
    shearY_ = component(direction, y_) / along;
    scale_ = 1 / along;
  }

  // Returns where the beam hits the triangle with these corners; the range is 0 if the beam misses the triangle.
  TriangleHit intersect(const Vec3d& a, const Vec3d& b, const Vec3d& c) const {
    const Vec3d p = sheared(a);
    const Vec3d q = sheared(b);
    const Vec3d r = sheared(c);
    const double u = r.x * q.y - r.y * q.x;
    const double v = p.x * r.y - p.y * r.x;
    const double w = q.x * p.y - q.y * p.x;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return {};
    const double area = u + v + w;
    if (area == 0) return {};  // the beam lies in the triangle's plane
    const double range = (u * p.z + v * q.z + w * r.z) / area * scale_;
    if (!(range > 0)) return {};
    return {range, v / area, w / area};
  }

 private:
  static double component(const Vec3d& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

  // Returns a corner in sheared coordinates. The z coordinate is the distance along the axis z_, which intersect()
  // converts to a distance along the beam.
  Vec3d sheared(const Vec3d& corner) const {
    const Vec3d p = corner - origin_;
    const double z = component(p, z_);
    return {component(p, x_) - shearX_ * z, component(p, y_) - shearY_ * z, z};
  }

  Vec3d origin_;
  int x_, y_, z_;  // indices of the axes that become x, y and z
  double shearX_, shearY_, scale_;
};

// User data of a placed mesh, which Embree passes to the callbacks.
struct PlacedGeometry {
  const PlacedBlock* placed;
  double radius;  // radius of its world (m), see ExactWorld::radius
};

// The scene's triangles relative to one origin. Each placed mesh is an Embree geometry, whose geometry id is the mesh's
// index in World::placed.
struct ExactWorld {
  World world;
  std::vector<PlacedGeometry> placements;
  double radius = 0;  // maximum distance of beam origins from the world's origin (m)
};

struct CandidateHit {
  double range;            // distance of the hit along the beam (m)
  std::uint32_t placed;    // index into World::placed
  std::uint32_t triangle;  // index in the block of `placed`
};

// The data of a ray, which Embree passes to the callbacks.
struct ExactContext {
  EmbreeContext embree = newEmbreeContext();
  const ExactWorld* world;
  const ShearedBeam* beam;
  double far;                        // hits beyond this range are ignored (m); shrinks when a nearer hit is found
  std::vector<CandidateHit>* found;  // receives all hits within the final `far`, and some beyond it
};

// Returns the corners of a triangle relative to the world's origin (m).
std::array<Vec3d, 3> cornersOf(const PlacedBlock& placed, std::uint32_t triangle) {
  const TriangleBlock& block = *placed.block;
  const Triangle& t = block.corners[triangle];
  const auto corner = [&](int k) { return placed.originFromMesh * Vec3d(block.vertices[t[k]]); };
  return {corner(0), corner(1), corner(2)};
}

float roundDown(double x) {
  return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity());
}

float roundUp(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

// Gives Embree the bounding box of a triangle, enlarged by twice the error of Embree's rays: the rounding of a ray's
// origin, plus the rounding of its direction times the distance to the triangle.
void boundTriangle(const RTCBoundsFunctionArguments* arguments) {
  const auto& placement = *static_cast<const PlacedGeometry*>(arguments->geometryUserPtr);
  Box box;
  double farthest = 0;  // distance of the corners from the origin (m)
  for (const Vec3d& corner : cornersOf(*placement.placed, arguments->primID)) {
    box.add(corner);
    farthest = std::max(farthest, length(corner));
  }
  const double slack = 2 * (kRounding + kAlongAnAxis) * (2 * placement.radius + farthest);
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = roundDown(box.low.x - slack);
  bounds.lower_y = roundDown(box.low.y - slack);
  bounds.lower_z = roundDown(box.low.z - slack);
  bounds.upper_x = roundUp(box.high.x + slack);
  bounds.upper_y = roundUp(box.high.y + slack);
  bounds.upper_z = roundUp(box.high.z + slack);
}

// Intersects a ray with a triangle, adds the hit to ExactContext::found unless it is transparent, and shortens the ray.
// Embree traces single rays here, so only lane 0 of the packet is used.
void intersectTriangle(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto& context = *reinterpret_cast<ExactContext*>(arguments->context);
  const PlacedBlock& placed = *static_cast<const PlacedGeometry*>(arguments->geometryUserPtr)->placed;
  const std::uint32_t triangle = arguments->primID;
  const auto [a, b, c] = cornersOf(placed, triangle);
  const TriangleHit hit = context.beam->intersect(a, b, c);
  if (!(hit.range > 0) || hit.range > context.far) return;
  const TriangleBlock& block = *placed.block;
  if (triangle >= block.firstAlpha && transparentAt(context.world->world, block, triangle, hit.u, hit.v)) return;
  context.found->push_back({hit.range, arguments->geomID, triangle});
  const double far = coplanarReach(hit.range);
  if (far >= context.far) return;
  context.far = far;
  RTCRayN_tfar(RTCRayHitN_RayN(arguments->rayhit, 1), 1, 0) = roundUp(far);
}

// Returns a sort key that decides between coplanar surfaces: the hit with the lowest key wins, as in the filter of the
// ray-tracing method for a flattened scene.
auto coplanarRank(const World& world, const CandidateHit& hit) {
  const PlacedBlock& placed = world.placed[hit.placed];
  const std::uint32_t id = instanceId(placed.firstInstanceId, placed.block->surfaceOf(hit.triangle).instance);
  const bool hasAlpha = hit.triangle >= placed.block->firstAlpha;
  return std::tuple(id, hasAlpha, hit.placed, hit.triangle);
}

double incidenceCosine(const World& world, const CandidateHit& hit, const Vec3d& direction) {
  const PlacedBlock& placed = world.placed[hit.placed];
  return std::abs(dot(normalized(placed.normalFromMesh * placed.block->triangles[hit.triangle].normal), direction));
}

// Returns the hit that the tracer reports: among the hits that are coplanar with the nearest hit, the hit with the
// lowest coplanarRank(), whatever the order of `found`. `found` must not be empty.
CandidateHit reportedHit(const World& world, const std::vector<CandidateHit>& found, const Vec3d& direction) {
  if (found.size() == 1) return found.front();
  const CandidateHit nearest = *std::ranges::min_element(
      found, {}, [&](const CandidateHit& hit) { return std::tuple(hit.range, coplanarRank(world, hit)); });
  const double far = coplanarReach(nearest.range);
  const double tolerance = double{kCoplanar} * nearest.range + kFloor;
  const double cosine = incidenceCosine(world, nearest, direction);
  CandidateHit lowest = nearest;
  for (const CandidateHit& hit : found) {
    if (hit.range > far || !(coplanarRank(world, hit) < coplanarRank(world, lowest))) continue;
    const double distance = (hit.range - nearest.range) * std::max(cosine, incidenceCosine(world, hit, direction));
    if (distance <= tolerance) lowest = hit;
  }
  return lowest;
}

// Returns a component of a ray's direction for Embree. Tiny components become 0, as in ray tracing, since Embree 3.13
// misses hits of rays with components below 1e-18.
double embreeComponent(double component) {
  return std::abs(component) < kAlongAnAxis ? 0.0 : component;
}

// Returns Embree's hierarchy of all placed meshes. Its callbacks read `built`, which must outlive the hierarchy.
SceneHandle hierarchyOf(RTCDevice device, const ExactWorld& built) {
  SceneHandle scene(rtcNewScene(device), rtcReleaseScene);
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  for (std::uint32_t i = 0; i < built.placements.size(); ++i) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(built.world.placed[i].block->triangles.size()));
    rtcSetGeometryUserData(geometry, const_cast<PlacedGeometry*>(&built.placements[i]));
    rtcSetGeometryBoundsFunction(geometry, boundTriangle, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersectTriangle);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene.get(), geometry, i);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene.get());
  return scene;
}

}  // namespace

class ExactTracer::Impl {
 public:
  explicit Impl(const Scene& scene)
      : scene_(scene),
        anchor_(scene.bounds().empty() ? Vec3d{} : scene.bounds().center()),
        device_(makeDevice()),
        materials_(compactMaterials(scene)) {
    if (scene.moves()) throw Error("the exact reference takes scenes whose objects stand still");
    blocks_.resize(scene.meshes.size());
    parallelForEach(blocks_.size(), 1, [&](std::size_t m) { blocks_[m] = blockOf(scene, scene.meshes[m]); });
    if (materials_.empty()) materials_.emplace_back();
  }

  void trace(const Shot& shot, Channels channels, ExactHits& out) const {
    const BeamTable& beams = *shot.beams;
    out.hits.reset(beams.rings, beams.columns, channels);
    out.range.resize(out.hits.size());
    const std::shared_ptr<const ExactWorld> world = worldNear(shot);
    const ShotFrame frame = frameOf(shot, world->world.origin);
    const std::uint32_t tilesPerRing = (beams.columns + kPacket - 1) / kPacket;
    parallelFor(std::size_t{tilesPerRing} * beams.rings, 64, [&](std::size_t first, std::size_t last) {
      std::vector<CandidateHit> found;
      for (std::size_t i = first; i < last; ++i) {
        const auto ring = static_cast<std::uint32_t>(i / tilesPerRing);
        const auto column = static_cast<std::uint32_t>(i % tilesPerRing) * kPacket;
        traceTile(*world, shot, frame, {ring, column, 1, std::min<std::uint32_t>(kPacket, beams.columns - column)},
                  found, out);
      }
    });
  }

 private:
  // Traces the beams of a tile and stores their hits in `out`. `found`: a buffer that is reused.
  void traceTile(const ExactWorld& world, const Shot& shot, const ShotFrame& frame, const Tile& tile,
                 std::vector<CandidateHit>& found, ExactHits& out) const {
    Rays rays;
    setUpRays(shot, frame, tile, rays);
    HitPlanes resolved;
    HitTriangle triangles[kPacket];
    for (int i = 0; i < kPacket; ++i) {
      loadMiss(resolved, i);
      if (i >= rays.count) continue;
      const Vec3d origin{rays.ox[i], rays.oy[i], rays.oz[i]};
      const Vec3d direction{rays.dx[i], rays.dy[i], rays.dz[i]};
      const ShearedBeam beam(origin, direction);
      found.clear();
      ExactContext context{.world = &world, .beam = &beam, .far = coplanarReach(shot.beams->maxRange), .found = &found};
      const Vec3d forEmbree{embreeComponent(direction.x), embreeComponent(direction.y), embreeComponent(direction.z)};
      RTCRayHit ray = newRay(origin, forEmbree, 0, roundUp(context.far));
      intersectOne(world.world.embree.get(), context.embree, ray);  // appends the beam's hits to `found`
      if (found.empty()) continue;
      const CandidateHit hit = reportedHit(world.world, found, direction);
      const PlacedBlock& placed = world.world.placed[hit.placed];
      triangles[i] = {placed.block, &placed, hit.triangle};
      loadPlane(triangles[i], 0, resolved, i);
      resolved.traced[i] = hit.range;
    }
    useTracedRanges(rays, *shot.beams, resolved);
    store(materials_, tile, rays, resolved, triangles, out.hits);
    std::copy_n(resolved.range, tile.width, &out.range[std::size_t{tile.ring} * out.hits.columns + tile.column]);
  }

  // Returns the world whose origin is the grid point nearest to the sensor; builds the world if it is not cached. The
  // world's radius includes all points from which beams of the shot start.
  std::shared_ptr<const ExactWorld> worldNear(const Shot& shot) const {
    const auto cell = [](double d) { return std::round(d / kGrid) * kGrid; };
    const Vec3d offset = shot.worldFromSensor.front().translation - anchor_;
    const Vec3d origin = anchor_ + Vec3d{cell(offset.x), cell(offset.y), cell(offset.z)};
    double beamOrigin = 0;  // largest distance of a beam's origin from the sensor (m)
    for (const Vec3f& o : shot.beams->origin) beamOrigin = std::max(beamOrigin, length(Vec3d(o)));
    double sensor = 0;  // largest distance of the sensor from the world's origin (m)
    for (const Pose& pose : shot.worldFromSensor) sensor = std::max(sensor, length(pose.translation - origin));
    double radius = kGrid;
    while (radius < beamOrigin + sensor) radius *= 2;

    const std::scoped_lock lock(mutex_);
    return worlds_.findOrAdd(
        [&](const auto& cached) { return cached->world.origin == origin && cached->radius >= radius; }, kCachedWorlds,
        [&] { return build(origin, radius); });
  }

  // Builds the world with this origin. `radius`: see ExactWorld::radius.
  std::shared_ptr<const ExactWorld> build(const Vec3d& origin, double radius) const {
    auto built = std::make_shared<ExactWorld>();
    World& world = built->world;
    world.origin = origin;
    world.scene = &scene_;
    built->radius = radius;
    for (const Instance& instance : scene_.instances) {
      const Affine originFromMesh{instance.worldFromMesh.linear, instance.worldFromMesh.translation - origin};
      world.placed.push_back({blocks_[instance.mesh].get(), originFromMesh, transposed(inverse(originFromMesh.linear)),
                              instance.firstInstanceId});
    }
    built->placements.reserve(world.placed.size());
    for (const PlacedBlock& placed : world.placed) built->placements.push_back({&placed, radius});
    world.embree = hierarchyOf(device_.get(), *built);
    return built;
  }

  const Scene& scene_;
  Vec3d anchor_;
  DeviceHandle device_;
  std::vector<std::unique_ptr<const TriangleBlock>> blocks_;  // indexed by mesh
  std::vector<CompactMaterial> materials_;
  mutable std::mutex mutex_;
  mutable RecentlyUsed<std::shared_ptr<const ExactWorld>> worlds_;
};

ExactTracer::ExactTracer(const Scene& scene) : impl_(std::make_unique<const Impl>(scene)) {}
ExactTracer::~ExactTracer() = default;

void ExactTracer::trace(const Shot& shot, Channels channels, ExactHits& hits) const {
  impl_->trace(shot, channels, hits);
}

}  // namespace scanmill
