#include "methods/particle/flight.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scanmill {

namespace {

// Particles fly a little past the sensor's maximum range: float32 must not decide what lies at exactly the maximum.
double farthest(const BeamTable& beams) {
  return beams.maxRange * (1 + 1e-4) + 1e-3;
}

constexpr double kSteep = 1e-12;  // components of directions that are smaller count as this

double inverseOf(double d) {
  return 1 / (std::fabs(d) < kSteep ? kSteep : d);
}

// The part of a line inside of the box: m along it.
struct Stretch {
  double begin, end;
};

Stretch insideOf(const Box& box, const Vec3d& o, const Vec3d& d) {
  Stretch s{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  const auto cut = [&](double low, double high, double from, double direction) {
    const double inverse = inverseOf(direction);
    const double a = (low - from) * inverse;
    const double b = (high - from) * inverse;
    s.begin = std::max(s.begin, std::min(a, b));
    s.end = std::min(s.end, std::max(a, b));
  };
  cut(box.low.x, box.high.x, o.x, d.x);
  cut(box.low.y, box.high.y, o.y, d.y);
  cut(box.low.z, box.high.z, o.z, d.z);
  return s;
}

bool insideBox(const Box& box, const Vec3d& p) {
  return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x && p.y <= box.high.y &&
         p.z <= box.high.z;
}

Vec3f fieldFrame(const Field& field, const Vec3d& point) {
  return Vec3f((point - field.shape.centre) * (1 / field.shape.voxel));
}

// A hit's triangle, and how far it is.
struct Rest {
  std::uint32_t triangle;
  double range;  // m
};

// How far from its plane a particle's triangle may be for the plane to be trusted: what rests at kRest voxels of a
// surface is named by a corner at most half a diagonal from there.
constexpr float kTrusted = 1.5f;  // voxels
// Where the distance at the corrected place is larger, there is no surface: beyond the edge of the triangle's plane.
constexpr float kThere = 0.6f;  // voxels

constexpr double kRounding = 2e-3;  // voxels, of distances and places in float32

// The gradient of the distance to a flat surface is its normal, and the nearest triangle's is exact, so the particle
// goes on along the beam to that triangle's plane. What it meets there may have another triangle nearest to it: then to
// that one's plane, once more.
Rest corrected(const Flight& flight, const Vec3d& o, const Vec3d& d, Rest rest) {
  const Field& field = flight.field;
  for (int turn = 0; turn < 2; ++turn) {
    const BlockTriangle& plane = flight.world.baked.triangles[rest.triangle];
    const Vec3d here = o + d * rest.range;
    const double away = plane.offset - dot(plane.normal, here);
    const double range = rest.range + away / dot(plane.normal, d);
    if (!(std::abs(away) <= double{kTrusted} * voxelAt(field, fieldFrame(field, here))) || !(range >= 0)) return rest;
    const Vec3d there = o + d * range;
    if (!insideBox(flight.box, there)) return rest;
    const FieldPlace after = placeIn(field, fieldFrame(field, there));
    if (!(after.distance <= kThere)) return rest;
    const bool same = after.triangle == rest.triangle || after.triangle == kNoWord;
    rest = {same ? rest.triangle : after.triangle, range};
    if (same) break;
  }
  return rest;
}

// Interpolated distances are too small where walls meet: a particle that rests farther than half a voxel from the plane
// of its triangle is taken for one at a brink.
void settle(const Flight& flight, const Rays& rays, int lane, Particles& particles, std::size_t i, Landings& landings) {
  const TriangleBlock& block = flight.world.baked;
  if (landings.outcomeOf(i) == Outcome::Hit && landings.way[i] > particles.begin[i]) {
    const double way = double{landings.way[i]} * flight.field.shape.voxel;
    const Vec3d point =
        Vec3d{rays.ox[lane], rays.oy[lane], rays.oz[lane]} + Vec3d{rays.dx[lane], rays.dy[lane], rays.dz[lane]} * way;
    const BlockTriangle& plane = block.triangles[landings.triangle[i]];
    const double away = std::abs(dot(plane.normal, point) - plane.offset);
    const double voxel = voxelAt(flight.field, fieldFrame(flight.field, point));
    const double rest = std::clamp(double{flight.march.cone} * way / voxel, double{kRest}, double{kWidestHit});
    if (away > (rest + kRounding) * voxel) {
      landings.outcome[i] = static_cast<std::uint32_t>(Outcome::Brink) + 4 * landings.stepsOf(i);
    }
  }
  settleBrink(flight.field, block, flight.march, particles, i, landings);
}

// Flies on through transparent triangles.
void passTransparent(const Flight& flight, const Rays& rays, int lane, Particles& particles, std::size_t i,
                     Landings& landings) {
  const TriangleBlock& block = flight.world.baked;
  while (landings.outcomeOf(i) == Outcome::Hit && landings.triangle[i] >= block.firstAlpha) {
    const std::uint32_t triangle = landings.triangle[i];
    const Vec3d point =
        Vec3d{rays.ox[lane], rays.oy[lane], rays.oz[lane]} +
        Vec3d{rays.dx[lane], rays.dy[lane], rays.dz[lane]} * (double{landings.way[i]} * flight.field.shape.voxel);
    const Vec2d at = barycentric({&block, nullptr, triangle}, point);
    if (!transparentAt(flight.world, block, triangle, at.x, at.y)) return;
    const std::uint32_t taken = landings.stepsOf(i);
    MarchOptions rest = flight.march;
    rest.steps = rest.steps > taken ? rest.steps - taken : 0;
    particles.begin[i] = landings.way[i] + std::max(2e-3f, landings.way[i] * 1e-5f);
    const Landing next = marchOne(flight.field, block, rest, particles, i);
    landings.way[i] = next.way;
    landings.triangle[i] = next.triangle;
    landings.outcome[i] = static_cast<std::uint32_t>(next.outcome) + 4 * (next.steps + taken);
  }
}

}  // namespace

FlightCounts& FlightCounts::operator+=(const FlightCounts& o) {
  exhausted += o.exhausted;
  left += o.left;
  touching += o.touching;
  return *this;
}

void launch(const Flight& flight, std::span<const Tile> tiles, Particles& particles, std::size_t first) {
  const bool lists = flight.field.shape.lists;
  const Vec3d centre = flight.field.shape.centre;
  const double perVoxel = 1 / flight.field.shape.voxel;
  const double end = farthest(*flight.shot.beams);
  Rays rays;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    setUp(flight.shot, flight.frame, tiles[t], rays);
    for (int lane = 0; lane < kPacket; ++lane) {
      const std::size_t i = first + t * kPacket + static_cast<std::size_t>(lane);
      const Vec3d o{rays.ox[lane], rays.oy[lane], rays.oz[lane]};
      const Vec3d d{rays.dx[lane], rays.dy[lane], rays.dz[lane]};
      const Stretch inside = insideOf(flight.box, o, d);
      particles.ox[i] = static_cast<float>((o.x - centre.x) * perVoxel);
      particles.oy[i] = static_cast<float>((o.y - centre.y) * perVoxel);
      particles.oz[i] = static_cast<float>((o.z - centre.z) * perVoxel);
      particles.dx[i] = static_cast<float>(d.x);
      particles.dy[i] = static_cast<float>(d.y);
      particles.dz[i] = static_cast<float>(d.z);
      particles.begin[i] = static_cast<float>(std::max(inside.begin, 0.0) * perVoxel);
      particles.end[i] = lane < rays.count ? static_cast<float>(std::min(inside.end, end) * perVoxel) : 0.0f;
      if (!lists) continue;
      particles.wx[i] = static_cast<float>(o.x);
      particles.wy[i] = static_cast<float>(o.y);
      particles.wz[i] = static_cast<float>(o.z);
      particles.ix[i] = static_cast<float>(inverseOf(d.x));
      particles.iy[i] = static_cast<float>(inverseOf(d.y));
      particles.iz[i] = static_cast<float>(inverseOf(d.z));
    }
  }
}

FlightCounts land(const Flight& flight, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                  Particles& particles, Landings& landings, std::size_t first, Hits& hits,
                  std::vector<std::uint32_t>& unresolved) {
  const TriangleBlock& block = flight.world.baked;
  const bool lists = flight.field.shape.lists;
  const bool alpha = lists && block.firstAlpha < block.triangles.size();
  const double voxel = flight.field.shape.voxel;
  const auto end = static_cast<float>(farthest(*flight.shot.beams) / voxel);
  FlightCounts counts;
  Rays rays;
  Resolved resolved;
  HitTriangle triangles[kPacket];
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const Tile& tile = tiles[t];
    setUp(flight.shot, flight.frame, tile, rays);
    for (int lane = 0; lane < kPacket; ++lane) {
      const std::size_t i = first + t * kPacket + static_cast<std::size_t>(lane);
      triangles[lane] = {};
      if (lane < rays.count) {
        if (!lists) settle(flight, rays, lane, particles, i, landings);
        if (alpha) passTransparent(flight, rays, lane, particles, i, landings);
        const Outcome outcome = landings.outcomeOf(i);
        const bool left = outcome == Outcome::Miss && !flight.whole && particles.end[i] < end;
        if (outcome == Outcome::Exhausted || left) {
          ++(left ? counts.left : counts.exhausted);
          const auto l = static_cast<std::uint32_t>(lane);
          unresolved.push_back((tile.ring + l / tile.width) * hits.columns + tile.column + l % tile.width);
        }
        if (outcome == Outcome::Hit) triangles[lane] = {&block, nullptr, landings.triangle[i]};
      }
      if (triangles[lane].block == nullptr) {
        loadMiss(resolved, lane);
        continue;
      }
      double range = double{landings.way[i]} * voxel;
      if (!lists && landings.way[i] <= 0) ++counts.touching;
      if (flight.refine == ParticleOptions::Refine::ByNormal) {
        const Rest rest = corrected(flight, {rays.ox[lane], rays.oy[lane], rays.oz[lane]},
                                    {rays.dx[lane], rays.dy[lane], rays.dz[lane]}, {landings.triangle[i], range});
        triangles[lane].index = rest.triangle;
        range = rest.range;
      }
      loadPlane(triangles[lane], static_cast<float>(range), resolved, lane);
    }
    if (lists) {
      intersectPlanes(rays, *flight.shot.beams, resolved);
    } else {
      keepTraced(rays, *flight.shot.beams, resolved);
    }
    store(materials, tile, rays, resolved, triangles, hits);
  }
  return counts;
}

}  // namespace scanmill
