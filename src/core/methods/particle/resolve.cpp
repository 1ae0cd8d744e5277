#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "methods/field/march_rule.h"
#include "methods/particle/particles.h"

namespace scanmill {

namespace {

// Converts a point (m, relative to the world's origin) to the field's frame.
Vec3f toFieldFrame(const DistanceField& field, const Vec3d& point) {
  return Vec3f((point - field.shape.centre) * (1 / field.shape.voxel));
}

// Returns the triangle that a beam hits at about `range` (m) in a field without lists: either `triangle`, or a triangle
// of a thin layer on it (march_rule.h). `origin`: m, relative to the world's origin.
std::uint32_t triangleOrLayer(const MarchJob& job, const Vec3d& origin, const Vec3d& direction, double range,
                              std::uint32_t triangle) {
  const DistanceField& field = job.field();
  const BlockTriangle& plane = job.triangles().triangles[triangle];
  const Vec3d hitPoint = origin + direction * range;
  const Vec3d onPlane = hitPoint + plane.normal * (plane.offset - dot(plane.normal, hitPoint));
  const double voxel = voxelSizeAt(field, toFieldFrame(field, hitPoint));
  const double beamSide = dot(plane.normal, direction) > 0 ? -1 : 1;  // the sign of the side from which the beam comes
  const Vec3d inFront = onPlane + plane.normal * (beamSide * kLayerLookupOffset * voxel);
  const std::uint32_t layer = triangleAt(field, toFieldFrame(field, inFront));
  if (layer == kNoTriangle || layer == triangle) return triangle;
  const BlockTriangle& layerPlane = job.triangles().triangles[layer];
  const bool isLayer = std::abs(dot(layerPlane.normal, plane.normal)) > kLayerMinCosine &&
                       std::abs(dot(layerPlane.normal, onPlane) - layerPlane.offset) <= kLayerThickness * voxel;
  return isLayer ? layer : triangle;
}

// Returns the range (m) of a particle's hit.
double rangeOf(const MarchJob& job, const HitRecords& records, std::size_t i) {
  return double{records.travelled[i]} * job.field().shape.voxel;
}

// Lets each particle that hits a hole of a triangle's texture continue behind the hole, until it hits no more holes.
void passHoles(const MarchJob& job, std::span<const Tile> tiles, Particles& particles, HitRecords& records) {
  const TriangleBlock& block = job.triangles();
  if (block.firstAlpha >= block.triangles.size()) return;
  std::vector<std::uint32_t> marched(records.size());  // particles whose latest hits have not been tested for holes
  std::iota(marched.begin(), marched.end(), 0u);
  Rays rays;
  while (true) {
    std::vector<std::uint32_t> passing;
    std::size_t tileOfRays = tiles.size();  // the tile whose rays are in `rays`
    for (const std::uint32_t i : marched) {
      if (records.outcomeOf(i) != Outcome::Hit || records.triangle[i] < block.firstAlpha) continue;
      const std::size_t tile = i / kPacket;
      if (tile != tileOfRays) setUpRays(job.shot, job.frame, tiles[tile], rays);
      tileOfRays = tile;
      const auto lane = static_cast<int>(i % kPacket);
      const Vec3d point = rays.origin(lane) + rays.direction(lane) * rangeOf(job, records, i);
      const Vec2d at = barycentric({&block, nullptr, records.triangle[i]}, point);
      if (!transparentAt(*job.sensorField.world, block, records.triangle[i], at.x, at.y)) continue;
      const float travelled = records.travelled[i];
      particles.begin[i] = travelled + std::max(kHoleSkip, travelled * kHoleSkipShare);
      passing.push_back(i);
    }
    if (passing.empty()) return;
    marchCpu(job.field(), block, job.maxSteps, particles, passing, records);
    marched = std::move(passing);
  }
}

// Appends the beams of a tile that are neither hits nor misses to `unresolved`, and counts them. A particle that missed
// has left the field: its beam is a miss only if the field covers the scene or the beam's path. `firstRecord`: index of
// the record of the tile's first beam.
void addUnresolved(const MarchJob& job, const Tile& tile, const Rays& rays, const HitRecords& records,
                   std::size_t firstRecord, UnreliableBeams& counts, std::vector<std::uint32_t>& unresolved) {
  std::optional<Sections> inside;  // computed when a beam of the tile needs it
  for (std::uint32_t lane = 0; lane < static_cast<std::uint32_t>(rays.count); ++lane) {
    const Outcome outcome = records.outcomeOf(firstRecord + lane);
    if (outcome == Outcome::Hit) continue;
    if (outcome == Outcome::Miss) {
      if (job.sensorField.coversScene) continue;
      if (!inside) inside = sectionsInsideBox(job, rays);
      if (!(inside->end[lane] < job.pathLength())) continue;
    }
    ++(outcome == Outcome::Miss ? counts.leftField : counts.exhausted);
    unresolved.push_back((tile.ring + lane / tile.width) * job.shot.beams->columns + tile.column + lane % tile.width);
  }
}

// Number of tiles whose triangles are prefetched together; these triangles fit into the L1 cache.
constexpr std::size_t kTilesTogether = 16;

// Prefetches the triangles hit by the rays of a group of tiles, because triangles are scattered in memory. The group
// has kTilesTogether tiles from `firstTile` on, or the tiles that remain. `tiles`: number of all tiles.
void prefetchHits(const MarchJob& job, const HitRecords& records, std::size_t firstTile, std::size_t tiles) {
  const std::size_t endTile = std::min(firstTile + kTilesTogether, tiles);
  for (std::size_t i = firstTile * kPacket; i < endTile * kPacket; ++i) {
    if (records.outcomeOf(i) == Outcome::Hit) prefetch(job.triangles().triangles[records.triangle[i]]);
  }
}

}  // namespace

UnreliableBeams resolve(const MarchJob& job, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                        Particles& particles, HitRecords& records, Hits& hits, std::vector<std::uint32_t>& unresolved) {
  const bool lists = job.field().shape.lists;
  if (lists) passHoles(job, tiles, particles, records);
  UnreliableBeams counts;
  Rays rays;
  HitPlanes planes;
  HitTriangle triangles[kPacket];
  prefetchHits(job, records, 0, tiles.size());
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const Tile& tile = tiles[t];
    const std::size_t firstRecord = t * kPacket;
    if (t % kTilesTogether == 0) prefetchHits(job, records, t + kTilesTogether, tiles.size());
    prefetchStore(tile, hits);
    setUpRays(job.shot, job.frame, tile, rays);
    for (int lane = 0; lane < kPacket; ++lane) {
      const std::size_t i = firstRecord + static_cast<std::size_t>(lane);
      if (lane >= rays.count || records.outcomeOf(i) != Outcome::Hit) {
        triangles[lane] = {};
        loadMiss(planes, lane);
        continue;
      }
      const double range = rangeOf(job, records, i);
      std::uint32_t triangle = records.triangle[i];
      if (!lists) {
        counts.touching += range <= 0 ? 1 : 0;
        triangle = triangleOrLayer(job, rays.origin(lane), rays.direction(lane), range, triangle);
      }
      triangles[lane] = {&job.triangles(), nullptr, triangle};
      loadPlane(triangles[lane], static_cast<float>(range), planes, lane);
    }
    addUnresolved(job, tile, rays, records, firstRecord, counts, unresolved);
    if (lists) {
      usePlaneRanges(rays, *job.shot.beams, planes);
    } else {
      useTracedRanges(rays, *job.shot.beams, planes);
    }
    store(materials, tile, rays, planes, triangles, hits);
  }
  return counts;
}

}  // namespace scanmill
