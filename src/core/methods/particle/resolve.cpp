#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "methods/field/march_rule.h"
#include "methods/particle/particles.h"

namespace scanmill {

namespace {

Vec3f fieldFrame(const DistanceField& field, const Vec3d& point) {
  return Vec3f((point - field.shape.centre) * (1 / field.shape.voxel));
}

// Returns the triangle that a beam from `o` in direction `d` hits at about `range` (m): either `triangle`, or a
// triangle of a thin layer on it (march_rule.h).
std::uint32_t triangleOrLayer(const MarchJob& job, const Vec3d& o, const Vec3d& d, double range,
                              std::uint32_t triangle) {
  const DistanceField& field = job.field();
  const BlockTriangle& plane = job.triangles().triangles[triangle];
  const Vec3d here = o + d * range;
  const Vec3d onPlane = here + plane.normal * (plane.offset - dot(plane.normal, here));
  const double voxel = voxelSizeAt(field, fieldFrame(field, here));
  const double side = dot(plane.normal, d) > 0 ? -1 : 1;
  const Vec3d inFront = onPlane + plane.normal * (side * kLayerLookupOffset * voxel);
  const std::uint32_t other = triangleAt(field, fieldFrame(field, inFront));
  if (other == kNoWord || other == triangle) return triangle;
  const BlockTriangle& otherPlane = job.triangles().triangles[other];
  const bool layer = std::abs(dot(otherPlane.normal, plane.normal)) > kLayerMinCosine &&
                     std::abs(dot(otherPlane.normal, onPlane) - otherPlane.offset) <= kLayerThickness * voxel;
  return layer ? other : triangle;
}

double rangeOf(const MarchJob& job, const HitRecords& records, std::size_t i) {
  return double{records.travelled[i]} * job.field().shape.voxel;
}

// Lets the particles that hit a transparent point of a triangle continue behind it, again and again.
void passTransparent(const MarchJob& job, std::span<const Tile> tiles, Particles& particles, HitRecords& records) {
  const TriangleBlock& block = job.triangles();
  if (block.firstAlpha >= block.triangles.size()) return;
  const auto mayPass = [&](std::uint32_t i) {
    return records.outcomeOf(i) == Outcome::Hit && records.triangle[i] >= block.firstAlpha;
  };
  std::vector<std::uint32_t> marched;  // the particles whose records are new and may be at a transparent point
  for (std::uint32_t i = 0; i < records.size(); ++i) {
    if (mayPass(i)) marched.push_back(i);
  }
  Rays rays;
  while (!marched.empty()) {
    std::vector<std::uint32_t> passing;
    std::size_t tileOfRays = tiles.size();
    for (const std::uint32_t i : marched) {
      if (!mayPass(i)) continue;
      const std::uint32_t triangle = records.triangle[i];
      const std::size_t tile = i / kPacket;
      if (tile != tileOfRays) setUpRays(job.shot, job.frame, tiles[tile], rays);
      tileOfRays = tile;
      const auto lane = static_cast<int>(i % kPacket);
      const Vec3d point = rays.origin(lane) + rays.direction(lane) * rangeOf(job, records, i);
      const Vec2d at = barycentric({&block, nullptr, triangle}, point);
      if (!transparentAt(*job.sensorField.world, block, triangle, at.x, at.y)) continue;
      const float travelled = records.travelled[i];
      particles.begin[i] = travelled + std::max(kHoleSkip, travelled * kHoleSkipShare);
      passing.push_back(i);
    }
    marchCpu(job.field(), block, job.maxSteps, particles, passing, records);
    marched = std::move(passing);
  }
}

// Appends the beams of a tile that are neither hits nor misses to `unresolved`, and counts them. `firstRecord`: index
// of the record of the tile's first beam.
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

// Prefetches the triangles that the next kTilesTogether tiles have hit, because they are scattered in memory.
void prefetchHits(const MarchJob& job, const HitRecords& records, std::size_t first, std::size_t tiles) {
  for (std::size_t i = first; i < first + std::min(tiles, kTilesTogether) * kPacket; ++i) {
    if (records.outcomeOf(i) == Outcome::Hit) prefetch(job.triangles().triangles[records.triangle[i]]);
  }
}

}  // namespace

UnreliableBeams& UnreliableBeams::operator+=(const UnreliableBeams& o) {
  exhausted += o.exhausted;
  leftField += o.leftField;
  touching += o.touching;
  return *this;
}

UnreliableBeams resolve(const MarchJob& job, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                        Particles& particles, HitRecords& records, Hits& hits, std::vector<std::uint32_t>& unresolved) {
  const bool lists = job.field().shape.lists;
  if (lists) passTransparent(job, tiles, particles, records);
  UnreliableBeams counts;
  Rays rays;
  HitPlanes planes;
  HitTriangle triangles[kPacket];
  prefetchHits(job, records, 0, tiles.size());
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const Tile& tile = tiles[t];
    const std::size_t firstRecord = t * kPacket;
    if (t % kTilesTogether == 0) {
      const std::size_t next = std::min(t + kTilesTogether, tiles.size());
      prefetchHits(job, records, next * kPacket, tiles.size() - next);
    }
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
