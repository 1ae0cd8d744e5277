#include "methods/ray_tracing/filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/instruction_sets.h"

namespace scanmill {

namespace {

// Fields of Embree's RTCRayN and RTCHitN (Embree 3, rtcore_ray.h). Field f of ray i of N is the 32-bit word f * N + i.
enum RayField { kDirX = 4, kDirY = 5, kDirZ = 6, kFar = 8, kId = 10 };
enum HitField { kU = 3, kV = 4, kPrimitive = 5, kGeometry = 6, kInstance = 7 };

// Embree's ids of a triangle that a ray may hit.
struct Candidate {
  std::uint32_t instance, geometry, primitive;
};

// Returns the rank that the tie rule compares: the instance id, then the triangle's position in the scene, which
// depends neither on how meshes are divided into parts nor on which instances the world has.
std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t> rankOf(const World& world, const Candidate& c) {
  const HitTriangle hit = hitTriangle(world, c.instance, c.geometry, c.primitive);
  if (hit.placed == nullptr) return {instanceOf(hit), c.instance, c.geometry, c.primitive};
  return {instanceOf(hit), hit.placed->instance, c.geometry, hit.block->triangles[hit.index].primitive};
}

// Returns the absolute cosine of the angle between a ray's direction (world frame) and a triangle's normal.
float cosineOf(const World& world, const Candidate& c, const Vec3f& direction) {
  const HitTriangle hit = hitTriangle(world, c.instance, c.geometry, c.primitive);
  Vec3d normal = hit.block->triangles[hit.index].normal;
  if (hit.placed != nullptr) normal = normalized(hit.placed->normalFromMesh * normal);
  return static_cast<float>(std::abs(dot(normal, Vec3d(direction))));
}

// Accepts or rejects a candidate hit of a lane's ray at `distance` (m). If the candidate is accepted, returns true and
// sets the lane's nearest hit in the context, and `far`, the ray's end. `direction`: the ray's direction (world frame).
bool tryAccept(TieContext& context, std::uint32_t lane, float distance, const Vec3f& direction,
               const Candidate& candidate, float& far) {
  const float nearestSoFar = context.distance[lane];
  // Two hits tie if their gap is small along the normal of the surface that faces the ray more. Hits out of reach of
  // each other along the ray cannot tie.
  bool isTie = false;
  if (std::abs(distance - nearestSoFar) <= distance * kReach + context.floor) {
    const Candidate holder{context.instance[lane], context.geometry[lane], context.primitive[lane]};
    const float cosine =
        std::max(cosineOf(*context.world, candidate, direction), cosineOf(*context.world, holder, direction));
    isTie = std::abs(distance - nearestSoFar) * cosine <= kCoplanar * distance + context.floor;
    if (isTie && !(rankOf(*context.world, candidate) < rankOf(*context.world, holder))) return false;
  }
  if (!isTie && !(distance < nearestSoFar)) return false;
  // The minimum keeps a chain of ties from moving the hit away from the sensor.
  const float nearest = isTie ? std::min(distance, nearestSoFar) : distance;
  context.distance[lane] = nearest;
  context.instance[lane] = candidate.instance;
  context.geometry[lane] = candidate.geometry;
  context.primitive[lane] = candidate.primitive;
  far = nearest + (nearest * kReach + context.floor);
  return true;
}

// Filters the lanes one by one, for packets of any width. Sets `valid` to 0 in lanes whose candidate is rejected. On
// entry, a ray's `far` is the distance of its candidate; accepting the candidate sets `far` to the ray's new end.
void filterLanes(const RTCFilterFunctionNArguments* arguments, TieContext& context) {
  const unsigned n = arguments->N;
  auto* ray = reinterpret_cast<float*>(arguments->ray);
  const auto* ids = reinterpret_cast<const std::uint32_t*>(ray) + kId * n;
  const auto* hitIds = reinterpret_cast<const std::uint32_t*>(arguments->hit);
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    Vec3f direction{ray[kDirX * n + i], ray[kDirY * n + i], ray[kDirZ * n + i]};
    const Candidate candidate{hitIds[kInstance * n + i], hitIds[kGeometry * n + i], hitIds[kPrimitive * n + i]};
    if (candidate.instance != RTC_INVALID_GEOMETRY_ID) {  // Embree gives the ray in the instance's frame
      const PlacedBlock& placed = context.world->placed[candidate.instance - World::kFirstPlaced];
      direction = Vec3f(placed.originFromMesh.linear * Vec3d(direction));
    }
    float& far = ray[kFar * n + i];
    const float distance = far;
    if (!tryAccept(context, ids[i], distance, direction, candidate, far)) {
      arguments->valid[i] = 0;
      far = distance;
    }
  }
}

// Vectors of W values of 4 bytes, unaligned. W is at most 8, because GCC 12 compares vectors of 16 values one by one.
template <int W>
struct Lanes {
  typedef float Floats __attribute__((vector_size(4 * W), aligned(4), may_alias));
  typedef int Ints __attribute__((vector_size(4 * W), aligned(4), may_alias));
};

// Does what filterLanes() does, for packets whose lanes have consecutive ids. Filters all lanes at once, unless some
// candidate may tie with the nearest hit of its lane, which is rare. Uses vector types, because the compiler does not
// vectorise the loop of filterLanes().
template <int N>
void filterPacket(const RTCFilterFunctionNArguments* arguments, TieContext& context) {
  constexpr int kWidth = N < 8 ? N : 8;
  using Floats = typename Lanes<kWidth>::Floats;
  using Ints = typename Lanes<kWidth>::Ints;
  auto* ray = reinterpret_cast<float*>(arguments->ray);
  const auto* hit = reinterpret_cast<const float*>(arguments->hit);
  const std::uint32_t firstLane = reinterpret_cast<const std::uint32_t*>(ray)[kId * N];
  // Return references to the values of kWidth consecutive lanes, from `lane` on.
  const auto valid = [&](int lane) -> Ints& { return *reinterpret_cast<Ints*>(arguments->valid + lane); };
  const auto far = [&](int lane) -> Floats& { return *reinterpret_cast<Floats*>(ray + kFar * N + lane); };
  const auto nearestSoFar = [&](int lane) -> Floats& {
    return *reinterpret_cast<Floats*>(context.distance + firstLane + lane);
  };

  Ints tieCandidates = valid(0) & 0;
  for (int lane = 0; lane < N; lane += kWidth) {
    const Floats margin = far(lane) * kReach + context.floor;
    const Floats ahead = nearestSoFar(lane) - far(lane);
    tieCandidates |= valid(lane) & (ahead <= margin) & (-ahead <= margin);
  }
  int anyTie = 0;
  for (int i = 0; i < kWidth; ++i) anyTie |= tieCandidates[i];
  if (anyTie != 0) return filterLanes(arguments, context);
  for (int lane = 0; lane < N; lane += kWidth) {
    const Floats distance = far(lane);
    const Floats margin = distance * kReach + context.floor;
    const Ints accepted = valid(lane) & (nearestSoFar(lane) > distance);
    nearestSoFar(lane) = accepted ? distance : nearestSoFar(lane);
    const auto update = [&](std::uint32_t* column, int field) {
      auto& ids = *reinterpret_cast<Ints*>(column + firstLane + lane);
      ids = accepted ? *reinterpret_cast<const Ints*>(hit + field * N + lane) : ids;
    };
    update(context.geometry, kGeometry);
    update(context.primitive, kPrimitive);
    update(context.instance, kInstance);
    far(lane) = accepted ? distance + margin : distance;
    valid(lane) = accepted;
  }
}

// Rejects hits at which the texture's alpha is transparent.
void rejectTransparent(const RTCFilterFunctionNArguments* arguments, const World& world) {
  const unsigned n = arguments->N;
  const auto* hit = reinterpret_cast<const float*>(arguments->hit);
  const auto* hitIds = reinterpret_cast<const std::uint32_t*>(hit);
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const HitTriangle triangle =
        hitTriangle(world, hitIds[kInstance * n + i], hitIds[kGeometry * n + i], hitIds[kPrimitive * n + i]);
    const double u = hit[kU * n + i], v = hit[kV * n + i];
    if (transparentAt(world, *triangle.block, triangle.index, u, v)) arguments->valid[i] = 0;
  }
}

}  // namespace

void TieContext::reset() {
  std::fill_n(distance, kPacket, std::numeric_limits<float>::infinity());
  std::fill_n(instance, kPacket, RTC_INVALID_GEOMETRY_ID);
}

// Embree calls the filter with as many lanes as it tests at once on this CPU.
SCANMILL_BEST_INSTRUCTIONS void tieFilter(const RTCFilterFunctionNArguments* arguments) {
  auto& context = *reinterpret_cast<TieContext*>(arguments->context);
  if (arguments->N == 16) return filterPacket<16>(arguments, context);
  if (arguments->N == 8) return filterPacket<8>(arguments, context);
  if (arguments->N == 4) return filterPacket<4>(arguments, context);
  filterLanes(arguments, context);
}

void alphaTieFilter(const RTCFilterFunctionNArguments* arguments) {
  rejectTransparent(arguments, *reinterpret_cast<TieContext*>(arguments->context)->world);
  tieFilter(arguments);
}

}  // namespace scanmill
