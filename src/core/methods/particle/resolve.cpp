#include "methods/particle/resolve.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "methods/field/march_rule.h"
#include "methods/particle/launch.h"

namespace scanmill {

namespace {

Vec3f fieldFrame(const DistanceField& field, const Vec3d& point) {
  return Vec3f((point - field.shape.centre) * (1 / field.shape.voxel));
}

// A point at which a beam hits a surface.
struct SurfacePoint {
  std::uint32_t triangle;
  double range;  // m, from the beam's origin
};

// Returns the triangle that a beam with direction `d` hits at `place`, a point on the plane of `triangle`: either
// `triangle`, or a triangle of a thin layer on it (march_rule.h).
std::uint32_t layerTriangleAt(const MarchJob& job, std::uint32_t triangle, const Vec3d& place, const Vec3d& d,
                              double voxel) {
  const BlockTriangle& plane = job.triangles().triangles[triangle];
  const double side = dot(plane.normal, d) > 0 ? -1 : 1;
  const Vec3d aside = place + plane.normal * (side * kLayerLookupOffset * voxel);
  const std::uint32_t named = triangleAt(job.field(), fieldFrame(job.field(), aside));
  if (named == kNoWord || named == triangle) return triangle;
  const BlockTriangle& other = job.triangles().triangles[named];
  const bool layer = std::abs(dot(other.normal, plane.normal)) > kLayerMinCosine &&
                     std::abs(dot(other.normal, place) - other.offset) <= kLayerThickness * voxel;
  return layer ? named : triangle;
}

// Returns a hit with the triangle that the beam hits there, and with the same range.
SurfacePoint withLayerTriangle(const MarchJob& job, const Vec3d& o, const Vec3d& d, const SurfacePoint& hit) {
  const BlockTriangle& plane = job.triangles().triangles[hit.triangle];
  const Vec3d here = o + d * hit.range;
  const Vec3d onPlane = here + plane.normal * (plane.offset - dot(plane.normal, here));
  return {layerTriangleAt(job, hit.triangle, onPlane, d, voxelAt(job.field(), fieldFrame(job.field(), here))),
          hit.range};
}

double rangeOf(const MarchJob& job, const HitRecords& records, std::size_t i) {
  return double{records.travelled[i]} * job.field().shape.voxel;
}

Vec3d originOf(const Rays& rays, int lane) {
  return {rays.ox[lane], rays.oy[lane], rays.oz[lane]};
}

Vec3d directionOf(const Rays& rays, int lane) {
  return {rays.dx[lane], rays.dy[lane], rays.dz[lane]};
}

// Lets particles continue through the transparent parts of triangles.
void passTransparent(const MarchJob& job, std::span<const Tile> tiles, std::size_t first, HitRecords& records) {
  const TriangleBlock& block = job.triangles();
  if (block.firstAlpha >= block.triangles.size()) return;
  const auto mayPass = [&](std::size_t i) {
    return records.outcomeOf(first + i) == Outcome::Hit && records.triangle[first + i] >= block.firstAlpha;
  };
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < tiles.size() * kPacket; ++i) {
    if (mayPass(i)) open.push_back(i);
  }
  if (open.empty()) return;
  Particles particles;  // set up only for tiles with a particle that may continue
  particles.resize(tiles.size() * kPacket, true);
  std::size_t known = tiles.size();
  for (const std::uint32_t i : open) {
    const std::size_t tile = i / kPacket;
    if (tile != known) launch(job, tiles.subspan(tile, 1), particles, tile * kPacket);
    known = tile;
  }
  HitRecords ends;
  ends.reset(particles.size());
  Rays rays;
  while (!open.empty()) {
    std::vector<std::uint32_t> passing;
    known = tiles.size();  // index of the tile whose rays are set up; tiles.size(): none
    for (const std::uint32_t i : open) {
      const std::size_t tile = i / kPacket;
      const auto lane = static_cast<int>(i % kPacket);
      if (tile != known) setUpRays(job.shot, job.frame, tiles[tile], rays);
      known = tile;
      const std::uint32_t triangle = records.triangle[first + i];
      const Vec3d point = originOf(rays, lane) + directionOf(rays, lane) * rangeOf(job, records, first + i);
      const Vec2d at = barycentric({&block, nullptr, triangle}, point);
      if (!transparentAt(*job.around.world, block, triangle, at.x, at.y)) continue;
      particles.begin[i] =
          records.travelled[first + i] + std::max(kHoleSkip, records.travelled[first + i] * kHoleSkipShare);
      ends.copy(i, records, first + i);
      passing.push_back(i);
    }
    marchCpu(job.field(), block, job.steps, particles, passing, ends);
    for (const std::uint32_t i : passing) records.copy(first + i, ends, i);
    open.clear();
    std::copy_if(passing.begin(), passing.end(), std::back_inserter(open), mayPass);
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
                        HitRecords& records, std::size_t first, Hits& hits, std::vector<std::uint32_t>& unresolved) {
  const bool lists = job.field().shape.lists;
  const TriangleBlock& block = job.triangles();
  const BeamTable& beams = *job.shot.beams;
  if (lists) passTransparent(job, tiles, first, records);
  UnreliableBeams counts;
  Rays rays;
  HitPlanes planes;
  HitTriangle triangles[kPacket];
  prefetchHits(job, records, first, tiles.size());
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const Tile& tile = tiles[t];
    const std::size_t at = first + t * kPacket;
    if (t % kTilesTogether == 0) {
      const std::size_t next = std::min(t + kTilesTogether, tiles.size());
      prefetchHits(job, records, first + next * kPacket, tiles.size() - next);
    }
    prefetchStore(tile, hits);
    setUpRays(job.shot, job.frame, tile, rays);
    std::optional<Sections> inside;  // computed when a beam of the tile needs it
    for (int lane = 0; lane < kPacket; ++lane) {
      const std::size_t i = at + static_cast<std::size_t>(lane);
      const Outcome outcome = records.outcomeOf(i);
      triangles[lane] = {};
      if (lane < rays.count && outcome == Outcome::Hit) {
        SurfacePoint hit{records.triangle[i], rangeOf(job, records, i)};
        if (!lists) {
          counts.touching += hit.range <= 0 ? 1 : 0;
          hit = withLayerTriangle(job, originOf(rays, lane), directionOf(rays, lane), hit);
        }
        triangles[lane] = {&block, nullptr, hit.triangle};
        loadPlane(triangles[lane], static_cast<float>(hit.range), planes, lane);
        continue;
      }
      loadMiss(planes, lane);
      if (lane >= rays.count) continue;
      bool leftField = false;
      if (outcome == Outcome::Miss) {
        if (!job.around.coversScene && !inside) inside = sectionsInsideBox(job, rays);
        leftField = inside && inside->end[lane] < job.pathLength();
        if (!leftField) continue;
      }
      ++(leftField ? counts.leftField : counts.exhausted);
      const auto l = static_cast<std::uint32_t>(lane);
      unresolved.push_back((tile.ring + l / tile.width) * hits.columns + tile.column + l % tile.width);
    }
    if (lists) {
      usePlaneRanges(rays, beams, planes);
    } else {
      useTracedRanges(rays, beams, planes);
    }
    store(materials, tile, rays, planes, triangles, hits);
  }
  return counts;
}

}  // namespace scanmill
