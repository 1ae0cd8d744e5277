#include "methods/ray_tracing/packet.h"

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.h"
#include "scene/embree.h"

namespace scanmill {

namespace {

// Returns the length (m) to which a ray is traced if hits beyond `blockedBeyond` (m) do not matter; at most `far`. The
// margin exceeds the difference between the range that follows from a triangle's plane and the traced range.
float endOf(float blockedBeyond, float far) {
  constexpr auto kMargin = static_cast<float>(2 * kRangeErrorBound);
  return std::min(far, blockedBeyond + (blockedBeyond * kMargin + kMargin));
}

// Returns the largest distance (m) of the shot's positions from the shot's first position.
double travelOf(const Shot& shot) {
  double travel = 0;
  const Vec3d start = shot.worldFromSensor.front().translation;
  for (const Pose& pose : shot.worldFromSensor) travel = std::max(travel, length(pose.translation - start));
  return travel;
}

// Sets `ends`, by lane, to the lengths (m) to which a tile's rays are traced.
void findEnds(const PacketJob& job, const Tile& tile, float* ends) {
  const auto far = static_cast<float>(searchDistance(*job.shot.beams));
  std::fill_n(ends, kPacket, far);
  if (job.shot.blockedBeyond.empty()) return;
  for (std::uint32_t r = 0; r < tile.rows; ++r) {
    const std::size_t first = std::size_t{tile.ring + r} * job.shot.beams->columns + tile.column;
    for (std::uint32_t c = 0; c < tile.width; ++c) {
      ends[r * tile.width + c] = endOf(job.shot.blockedBeyond[first + c], far);
    }
  }
}

// Traces a packet and sets the nearest hits in `context`. `firedAt` (HitTriangle::firedAt), `ends` (m): one per lane.
void intersectRays(const PacketJob& job, const Rays& rays, const float* firedAt, const float* ends,
                   TieContext& context) {
  RTCRayHit16 packet;
  alignas(64) int valid[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    packet.ray.org_x[i] = static_cast<float>(rays.ox[i]);
    packet.ray.org_y[i] = static_cast<float>(rays.oy[i]);
    packet.ray.org_z[i] = static_cast<float>(rays.oz[i]);
    packet.ray.dir_x[i] = nonTiny(rays.dx[i]);
    packet.ray.dir_y[i] = nonTiny(rays.dy[i]);
    packet.ray.dir_z[i] = nonTiny(rays.dz[i]);
    packet.ray.tnear[i] = 0;
    packet.ray.tfar[i] = ends[i];
    packet.ray.time[i] = firedAt[i];
    packet.ray.mask[i] = ~0u;
    packet.ray.id[i] = static_cast<unsigned>(i);
    packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    valid[i] = i < rays.count ? -1 : 0;
  }
  intersectPacket(job.world.embree.get(), context.embree, valid, packet);
}

// Returns the triangle that a lane's ray hits; an empty HitTriangle for a miss. `triangles`: the triangles of the lanes
// before `lane`; the ray of the previous lane often hits the same triangle.
HitTriangle triangleOf(const World& world, const TieContext& context, int lane, const HitTriangle* triangles) {
  if (!(context.distance[lane] < INFINITY)) return {};
  const auto isUnchanged = [&](const std::uint32_t* ids) { return ids[lane] == ids[lane - 1]; };
  if (lane > 0 && context.distance[lane - 1] < INFINITY && isUnchanged(context.primitive) &&
      isUnchanged(context.geometry) && isUnchanged(context.instance)) {
    return triangles[lane - 1];
  }
  return hitTriangle(world, context.instance[lane], context.geometry[lane], context.primitive[lane]);
}

// A packet in progress: it is traced, then the records of its triangles are prefetched, then it is resolved.
struct Pending {
  Tile tile;
  Rays rays;
  HitTriangle triangles[kPacket];
  float traced[kPacket];   // m, range that Embree found
  float firedAt[kPacket];  // see HitTriangle::firedAt
};

// Sets the triangles and traced ranges of a packet whose rays are set up.
void intersect(const PacketJob& job, Pending& p) {
  TieContext context;
  context.world = &job.world;
  context.floor = job.coplanarFloor;
  context.reset();
  alignas(64) float ends[kPacket];
  findEnds(job, p.tile, ends);
  intersectRays(job, p.rays, p.firedAt, ends, context);
  for (int i = 0; i < kPacket; ++i) {
    p.triangles[i] = i < p.rays.count ? triangleOf(job.world, context, i, p.triangles) : HitTriangle{};
    p.traced[i] = context.distance[i];
  }
}

// Sets up and traces the packet of a tile, and prefetches what finish() reads.
SCANMILL_BEST_INSTRUCTIONS void begin(const PacketJob& job, const Tile& tile, Pending& p, Hits& hits) {
  p.tile = tile;
  prefetchStore(tile, hits);
  setUpRays(job.shot, job.frame, tile, p.rays);
  fillFiringFractions(job.shot, job.frame, tile, job.world.revolution.duration, p.firedAt);
  intersect(job, p);
  for (int i = 0; i < kPacket; ++i) {
    p.triangles[i].firedAt = p.firedAt[i];
    if (p.triangles[i].block != nullptr) prefetch(p.triangles[i].block->triangles[p.triangles[i].index]);
  }
}

// Resolves a traced packet and stores its hits.
SCANMILL_BEST_INSTRUCTIONS void finish(const PacketJob& job, const Pending& p, Hits& hits) {
  HitPlanes planes;
  for (int i = 0; i < kPacket; ++i) {
    const HitTriangle& hit = p.triangles[i];
    if (hit.block == nullptr) {
      loadMiss(planes, i);
    } else if (i > 0 && hit.sameTriangle(p.triangles[i - 1]) && (hit.placed == nullptr || !hit.placed->moves)) {
      loadSamePlane(p.traced[i], planes, i);
    } else {
      loadPlane(hit, p.traced[i], planes, i);
    }
  }
  usePlaneRanges(p.rays, *job.shot.beams, planes);
  store(job.materials, p.tile, p.rays, planes, p.triangles, hits);
}

}  // namespace

double farthestEnd(const Shot& shot, double farthestOrigin) {
  return travelOf(shot) + farthestOrigin + double{endOf(static_cast<float>(searchDistance(*shot.beams)), INFINITY)};
}

double farthestEnd(const Shot& shot) {
  constexpr float kLargestSensor = 1;   // m; a ray from farther away than this starts at a pane or mirror
  constexpr double kRoundUp = 1.00001;  // exceeds the rounding error of the squares
  const BeamTable& beams = *shot.beams;
  float farthestOrigin2 = 0;
  for (const Vec3f& o : beams.origin) farthestOrigin2 = std::max(farthestOrigin2, dot(o, o));
  if (farthestOrigin2 <= kLargestSensor * kLargestSensor || shot.blockedBeyond.empty()) {
    return farthestEnd(shot, kRoundUp * std::sqrt(farthestOrigin2));
  }
  const auto far = static_cast<float>(searchDistance(beams));
  double farthest = 0;  // m, from the sensor's origin
  for (std::size_t ray = 0; ray < beams.origin.size(); ++ray) {
    farthest = std::max(farthest, length(Vec3d(beams.origin[ray])) + double{endOf(shot.blockedBeyond[ray], far)});
  }
  return travelOf(shot) + farthest;
}

void tracePackets(const PacketJob& job, std::span<const Tile> tiles, Hits& hits) {
  // Two packets are in progress: while Embree traces a packet, the data for resolving the packet before is prefetched.
  Pending pending[2];
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    begin(job, tiles[i], pending[i % 2], hits);
    if (i > 0) finish(job, pending[(i - 1) % 2], hits);
  }
  if (!tiles.empty()) finish(job, pending[(tiles.size() - 1) % 2], hits);
}

}  // namespace scanmill
