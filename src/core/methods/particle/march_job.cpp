#include "methods/particle/march_job.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace scanmill {

namespace {

// Particles march a little past the sensor's maximum range: float32 must not decide what lies at exactly the maximum.
double farthest(const BeamTable& beams) {
  return beams.maxRange * (1 + 1e-4) + 1e-3;
}

constexpr double kSteep = 1e-12;  // components of directions that are smaller count as this

double inverseOf(double d) {
  return 1 / (std::fabs(d) < kSteep ? kSteep : d);
}

// The parts of lines inside of the box: m along them.
struct Stretches {
  alignas(64) Lane begin, end;
};

void cut(double low, double high, const Lane& from, const Lane& direction, Stretches& s) {
  for (int i = 0; i < kPacket; ++i) {
    const double inverse = inverseOf(direction[i]);
    const double a = (low - from[i]) * inverse;
    const double b = (high - from[i]) * inverse;
    s.begin[i] = std::max(s.begin[i], std::min(a, b));
    s.end[i] = std::min(s.end[i], std::max(a, b));
  }
}

bool insideBox(const Box& box, const Vec3d& p) {
  return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x && p.y <= box.high.y &&
         p.z <= box.high.z;
}

Vec3f fieldFrame(const DistanceField& field, const Vec3d& point) {
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

// Thin layers, such as markings on a road, are told by corners of the side from which the beam comes, beyond the layer:
// a place kAside from the surface is nearest to a corner that is at least kLayer from it.
constexpr double kLayer = 0.1;           // voxels, how thick layers may be; what is farther off is another thing
constexpr double kAside = 0.5 + kLayer;  // voxels

// Whether a triangle's plane runs through a place, of a plane with this normal, as a layer on it does.
bool isLayer(const BlockTriangle& triangle, const Vec3d& normal, const Vec3d& place, double voxel) {
  return std::abs(dot(triangle.normal, normal)) > 0.9 &&
         std::abs(dot(triangle.normal, place) - triangle.offset) <= kLayer * voxel;
}

// The gradient of the distance to a flat surface is its normal, and the nearest triangle's is exact, so the particle
// goes on along the beam to that triangle's plane. What it meets there may have another triangle nearest to it: then to
// that one's plane, once more.
Rest corrected(const MarchJob& job, const Vec3d& o, const Vec3d& d, Rest rest) {
  const DistanceField& field = job.field;
  for (int round = 0; round < 2; ++round) {
    const BlockTriangle& plane = job.world.baked.triangles[rest.triangle];
    const Vec3d here = o + d * rest.range;
    const double away = plane.offset - dot(plane.normal, here);
    const double range = rest.range + away / dot(plane.normal, d);
    const double voxel = voxelAt(field, fieldFrame(field, here));
    if (!(std::abs(away) <= double{kTrusted} * voxel) || !(range >= 0)) return rest;
    const Vec3d there = o + d * range;
    if (!insideBox(job.box, there)) return rest;
    if (!(placeIn(field, fieldFrame(field, there)).distance <= kThere)) return rest;
    const double side = dot(plane.normal, d) > 0 ? -1 : 1;
    const Vec3d aside = there + plane.normal * (side * kAside * voxel);
    const std::uint32_t corner = nearestCorner(field, fieldFrame(field, aside));
    const std::uint32_t named = corner == kNoWord ? kNoWord : field.word[corner];
    const bool same = named == rest.triangle || named == kNoWord ||
                      !isLayer(job.world.baked.triangles[named], plane.normal, there, voxel);
    rest = {same ? rest.triangle : named, range};
    if (same) break;
  }
  return rest;
}

// Interpolated distances are too small where walls meet: a particle that rests farther than half a voxel from the plane
// of its triangle is taken for a candidate for a grazing hit. Finds the lanes that are so, of particles that have gone
// `way` (m).
void findFar(const MarchJob& job, const Rays& rays, const Resolved& planes, const Lane& way, bool (&far)[kPacket]) {
  const DistanceField& field = job.field;
  const Vec3d centre = field.shape.centre;
  const double voxel = field.shape.voxel;
  const double perVoxel = 1 / voxel;
  const double cone{job.march.cone};
  alignas(64) double most[kPacket];
  alignas(64) double away[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const Vec3d point{rays.ox[i] + rays.dx[i] * way[i], rays.oy[i] + rays.dy[i] * way[i],
                      rays.oz[i] + rays.dz[i] * way[i]};
    away[i] = std::abs(planes.nx[i] * point.x + planes.ny[i] * point.y + planes.nz[i] * point.z - planes.offset[i]);
    const std::int32_t level = levelAt(field, static_cast<float>((point.x - centre.x) * perVoxel),
                                       static_cast<float>((point.y - centre.y) * perVoxel),
                                       static_cast<float>((point.z - centre.z) * perVoxel));
    const double size = voxel * std::bit_cast<float>(static_cast<std::uint32_t>(127 + level) << 23);
    const double wide = cone * way[i] / size;
    const double rest = std::min(std::max(wide, double{kRest}), double{kWidestHit});
    most[i] = (rest + kRounding) * size;
  }
  for (int i = 0; i < kPacket; ++i) far[i] = away[i] > most[i];
}

constexpr double kNoWay = 1e9;  // m: more than that is a miss

// Which lanes rest where the nearest corner lies beyond the plane of its triangle, or so near to it that a layer may
// lie between.
void findBeyond(const MarchJob& job, const Rays& rays, const Resolved& planes, bool (&beyond)[kPacket]) {
  const DistanceField& field = job.field;
  const Vec3d centre = field.shape.centre;
  const double voxel = field.shape.voxel;
  const double perVoxel = 1 / voxel;
  alignas(64) Lane px, py, pz, scale, ux, uy, uz, beyondBy;
  alignas(64) std::int32_t level[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const double way = planes.traced[i] < kNoWay ? planes.traced[i] : 0;
    px[i] = (rays.ox[i] + rays.dx[i] * way - centre.x) * perVoxel;
    py[i] = (rays.oy[i] + rays.dy[i] * way - centre.y) * perVoxel;
    pz[i] = (rays.oz[i] + rays.dz[i] * way - centre.z) * perVoxel;
    level[i] = levelAt(field, static_cast<float>(px[i]), static_cast<float>(py[i]), static_cast<float>(pz[i]));
  }
  for (int i = 0; i < kPacket; ++i) {
    const FieldLevel& l = field.levels[static_cast<std::size_t>(level[i])];
    scale[i] = double{l.scale};
    ux[i] = double{l.offset[0]};
    uy[i] = double{l.offset[1]};
    uz[i] = double{l.offset[2]};
  }
  for (int i = 0; i < kPacket; ++i) {
    // From the place to the nearest corner: voxels of the level.
    const auto toCorner = [&](double place, double offset) {
      const double u = place * scale[i] + offset;
      return std::floor(u + 0.5) - u;
    };
    const double size = voxel / scale[i];
    const double x = centre.x + px[i] * voxel + toCorner(px[i], ux[i]) * size;
    const double y = centre.y + py[i] * voxel + toCorner(py[i], uy[i]) * size;
    const double z = centre.z + pz[i] * voxel + toCorner(pz[i], uz[i]) * size;
    const double corner = planes.nx[i] * x + planes.ny[i] * y + planes.nz[i] * z - planes.offset[i];
    const double along = planes.nx[i] * rays.dx[i] + planes.ny[i] * rays.dy[i] + planes.nz[i] * rays.dz[i];
    beyondBy[i] = kLayer * size - (along > 0 ? -corner : corner);
  }
  for (int i = 0; i < kPacket; ++i) beyond[i] = beyondBy[i] > 0;
}

// Lets a particle march on through transparent triangles.
void passTransparent(const MarchJob& job, const Rays& rays, int lane, Particles& particles, std::size_t i,
                     HitRecords& records) {
  const TriangleBlock& block = job.world.baked;
  while (records.outcomeOf(i) == Outcome::Hit && records.triangle[i] >= block.firstAlpha) {
    const std::uint32_t triangle = records.triangle[i];
    const Vec3d point =
        Vec3d{rays.ox[lane], rays.oy[lane], rays.oz[lane]} +
        Vec3d{rays.dx[lane], rays.dy[lane], rays.dz[lane]} * (double{records.way[i]} * job.field.shape.voxel);
    const Vec2d at = barycentric({&block, nullptr, triangle}, point);
    if (!transparentAt(job.world, block, triangle, at.x, at.y)) return;
    const std::uint32_t taken = records.stepsOf(i);
    MarchOptions rest = job.march;
    rest.steps = rest.steps > taken ? rest.steps - taken : 0;
    particles.begin[i] = records.way[i] + std::max(2e-3f, records.way[i] * 1e-5f);
    const HitRecord next = marchOne(job.field, block, rest, particles, i);
    records.way[i] = next.way;
    records.triangle[i] = next.triangle;
    records.outcome[i] = static_cast<std::uint32_t>(next.outcome) + 4 * (next.steps + taken);
  }
}

// A tile of which not all hits are known yet.
struct OpenTile {
  Tile tile;
  std::size_t first;  // its particles
  Rays rays;
  Resolved planes;
  HitTriangle triangles[kPacket];
};

constexpr std::size_t kTilesTogether = 16;  // they stay in the first cache

class TileResolver {
 public:
  TileResolver(const MarchJob& job, const std::vector<CompactMaterial>& materials, Particles& particles,
               HitRecords& records, Hits& hits, std::vector<std::uint32_t>& unresolved)
      : job_(job),
        materials_(materials),
        particles_(particles),
        records_(records),
        hits_(hits),
        unresolved_(unresolved),
        end_(static_cast<float>(farthest(*job.shot.beams) / job.field.shape.voxel)) {}

  // What hits name lies anywhere in memory: all of it is asked for before the first is needed.
  void expect(std::span<const Tile> tiles, std::size_t first) const {
    const std::size_t count = std::min(tiles.size(), kTilesTogether) * kPacket;
    for (std::size_t i = first; i < first + count; ++i) {
      if (records_.outcomeOf(i) == Outcome::Hit) prefetch(job_.world.baked.triangles[records_.triangle[i]]);
    }
  }

  void begin(const Tile& tile, std::size_t first, OpenTile& a) {
    const TriangleBlock& block = job_.world.baked;
    const bool lists = job_.field.shape.lists;
    const bool alpha = lists && block.firstAlpha < block.triangles.size();
    a.tile = tile;
    a.first = first;
    expectStore(tile, hits_);
    setUp(job_.shot, job_.frame, tile, a.rays);
    for (int lane = 0; lane < kPacket; ++lane) {
      if (alpha && lane < a.rays.count) passTransparent(job_, a.rays, lane, particles_, indexOf(a, lane), records_);
      load(a, lane);
    }
    if (!lists) findGrazing(a);
  }

  // Settles the candidates for grazing hits of tiles that have begun.
  void settle(std::span<OpenTile> tiles) {
    if (candidates_.empty()) return;
    settleGrazing(job_.field, job_.world.baked, job_.march, particles_, candidates_, records_);
    for (const std::uint32_t i : candidates_) {
      if (records_.outcomeOf(i) == Outcome::Hit) prefetch(job_.world.baked.triangles[records_.triangle[i]]);
    }
    for (const std::uint32_t i : candidates_) {
      const std::size_t at = i - tiles.front().first;
      load(tiles[at / kPacket], static_cast<int>(at % kPacket));
    }
    candidates_.clear();
  }

  void finish(OpenTile& a) {
    for (int lane = 0; lane < a.rays.count; ++lane) count(a, lane);
    if (job_.refine == ParticleOptions::Refine::ByNormal) correct(a);
    if (job_.refine == ParticleOptions::Refine::None) nameFromOutside(a);
    if (job_.field.shape.lists) {
      intersectPlanes(a.rays, *job_.shot.beams, a.planes);
    } else {
      keepTraced(a.rays, *job_.shot.beams, a.planes);
    }
    store(materials_, a.tile, a.rays, a.planes, a.triangles, hits_);
  }

  const MarchCounts& counts() const { return counts_; }

 private:
  static std::size_t indexOf(const OpenTile& a, int lane) { return a.first + static_cast<std::size_t>(lane); }

  double rangeOf(std::size_t i) const { return double{records_.way[i]} * job_.field.shape.voxel; }

  void load(OpenTile& a, int lane) const {
    const std::size_t i = indexOf(a, lane);
    if (lane < a.rays.count && records_.outcomeOf(i) == Outcome::Hit) {
      a.triangles[lane] = {&job_.world.baked, nullptr, records_.triangle[i]};
      loadPlane(a.triangles[lane], static_cast<float>(rangeOf(i)), a.planes, lane);
    } else {
      a.triangles[lane] = {};
      loadMiss(a.planes, lane);
    }
  }

  void findGrazing(const OpenTile& a) {
    alignas(64) Lane way;
    for (int lane = 0; lane < kPacket; ++lane) {
      const bool hit = a.triangles[lane].block != nullptr;
      way[lane] = hit ? rangeOf(indexOf(a, lane)) : 0;
    }
    bool far[kPacket];
    findFar(job_, a.rays, a.planes, way, far);
    for (int lane = 0; lane < a.rays.count; ++lane) {
      const std::size_t i = indexOf(a, lane);
      if (far[lane] && a.triangles[lane].block != nullptr && records_.way[i] > particles_.begin[i]) {
        records_.outcome[i] = static_cast<std::uint32_t>(Outcome::Grazing) + 4 * records_.stepsOf(i);
      }
      if (records_.outcomeOf(i) != Outcome::Grazing) continue;
      candidates_.push_back(static_cast<std::uint32_t>(i));
    }
  }

  void count(const OpenTile& a, int lane) {
    const std::size_t i = indexOf(a, lane);
    const Outcome outcome = records_.outcomeOf(i);
    const bool left = outcome == Outcome::Miss && !job_.whole && particles_.end[i] < end_;
    if (outcome == Outcome::Exhausted || left) {
      ++(left ? counts_.left : counts_.exhausted);
      const auto l = static_cast<std::uint32_t>(lane);
      unresolved_.push_back((a.tile.ring + l / a.tile.width) * hits_.columns + a.tile.column + l % a.tile.width);
    }
    if (outcome == Outcome::Hit && !job_.field.shape.lists && records_.way[i] <= 0) ++counts_.touching;
  }

  // Without correction, only the names change: see kAside.
  void nameFromOutside(OpenTile& a) const {
    bool beyond[kPacket];
    findBeyond(job_, a.rays, a.planes, beyond);
    const DistanceField& field = job_.field;
    std::uint32_t corner[kPacket];
    Vec3d onPlane[kPacket];
    double voxel[kPacket];
    for (int lane = 0; lane < kPacket; ++lane) {
      corner[lane] = kNoWord;
      if (!beyond[lane] || a.triangles[lane].block == nullptr) continue;
      const Resolved& p = a.planes;
      const Rays& r = a.rays;
      const double range = p.traced[lane];
      const Vec3d point{r.ox[lane] + r.dx[lane] * range, r.oy[lane] + r.dy[lane] * range,
                        r.oz[lane] + r.dz[lane] * range};
      const Vec3d normal{p.nx[lane], p.ny[lane], p.nz[lane]};
      const double along = normal.x * r.dx[lane] + normal.y * r.dy[lane] + normal.z * r.dz[lane];
      const double side = along > 0 ? -1 : 1;
      voxel[lane] = voxelAt(field, fieldFrame(field, point));
      onPlane[lane] = point + normal * (p.offset[lane] - dot(normal, point));
      corner[lane] = nearestCorner(field, fieldFrame(field, onPlane[lane] + normal * (side * kAside * voxel[lane])));
      if (corner[lane] != kNoWord) __builtin_prefetch(&field.word[corner[lane]]);
    }
    for (std::uint32_t& named : corner) {
      if (named == kNoWord) continue;
      named = field.word[named];
      if (named != kNoWord) prefetch(job_.world.baked.triangles[named]);
    }
    for (int lane = 0; lane < kPacket; ++lane) {
      if (corner[lane] == kNoWord || corner[lane] == a.triangles[lane].index) continue;
      const Vec3d normal{a.planes.nx[lane], a.planes.ny[lane], a.planes.nz[lane]};
      if (!isLayer(job_.world.baked.triangles[corner[lane]], normal, onPlane[lane], voxel[lane])) continue;
      a.triangles[lane].index = corner[lane];
      loadPlane(a.triangles[lane], static_cast<float>(a.planes.traced[lane]), a.planes, lane);
    }
  }

  void correct(OpenTile& a) const {
    for (int lane = 0; lane < kPacket; ++lane) {
      if (a.triangles[lane].block == nullptr) continue;
      const Rest rest = corrected(job_, {a.rays.ox[lane], a.rays.oy[lane], a.rays.oz[lane]},
                                  {a.rays.dx[lane], a.rays.dy[lane], a.rays.dz[lane]},
                                  {a.triangles[lane].index, rangeOf(indexOf(a, lane))});
      a.triangles[lane].index = rest.triangle;
      loadPlane(a.triangles[lane], static_cast<float>(rest.range), a.planes, lane);
    }
  }

  const MarchJob& job_;
  const std::vector<CompactMaterial>& materials_;
  Particles& particles_;
  HitRecords& records_;
  Hits& hits_;
  std::vector<std::uint32_t>& unresolved_;
  float end_;  // of the way of a particle that nothing stops
  std::vector<std::uint32_t> candidates_;
  MarchCounts counts_;
};

}  // namespace

MarchCounts& MarchCounts::operator+=(const MarchCounts& o) {
  exhausted += o.exhausted;
  left += o.left;
  touching += o.touching;
  return *this;
}

void launch(const MarchJob& job, std::span<const Tile> tiles, Particles& particles, std::size_t first) {
  const bool lists = job.field.shape.lists;
  const Vec3d centre = job.field.shape.centre;
  const double perVoxel = 1 / job.field.shape.voxel;
  const double end = farthest(*job.shot.beams);
  Rays rays;
  Stretches inside;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    setUp(job.shot, job.frame, tiles[t], rays);
    std::fill_n(inside.begin, kPacket, 0.0);
    std::fill_n(inside.end, kPacket, end);
    cut(job.box.low.x, job.box.high.x, rays.ox, rays.dx, inside);
    cut(job.box.low.y, job.box.high.y, rays.oy, rays.dy, inside);
    cut(job.box.low.z, job.box.high.z, rays.oz, rays.dz, inside);
    std::fill(inside.end + rays.count, inside.end + kPacket, 0.0);
    const std::size_t at = first + t * kPacket;
    const auto fill = [at](std::vector<float>& column, const auto& valueOf) {
      float* values = column.data() + at;
      for (int lane = 0; lane < kPacket; ++lane) values[lane] = static_cast<float>(valueOf(lane));
    };
    fill(particles.ox, [&](int lane) { return (rays.ox[lane] - centre.x) * perVoxel; });
    fill(particles.oy, [&](int lane) { return (rays.oy[lane] - centre.y) * perVoxel; });
    fill(particles.oz, [&](int lane) { return (rays.oz[lane] - centre.z) * perVoxel; });
    fill(particles.dx, [&](int lane) { return rays.dx[lane]; });
    fill(particles.dy, [&](int lane) { return rays.dy[lane]; });
    fill(particles.dz, [&](int lane) { return rays.dz[lane]; });
    fill(particles.begin, [&](int lane) { return inside.begin[lane] * perVoxel; });
    fill(particles.end, [&](int lane) { return inside.end[lane] * perVoxel; });
    if (!lists) continue;
    fill(particles.wx, [&](int lane) { return rays.ox[lane]; });
    fill(particles.wy, [&](int lane) { return rays.oy[lane]; });
    fill(particles.wz, [&](int lane) { return rays.oz[lane]; });
    fill(particles.ix, [&](int lane) { return inverseOf(rays.dx[lane]); });
    fill(particles.iy, [&](int lane) { return inverseOf(rays.dy[lane]); });
    fill(particles.iz, [&](int lane) { return inverseOf(rays.dz[lane]); });
  }
}

MarchCounts resolve(const MarchJob& job, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                    Particles& particles, HitRecords& records, std::size_t first, Hits& hits,
                    std::vector<std::uint32_t>& unresolved) {
  TileResolver resolver(job, materials, particles, records, hits, unresolved);
  OpenTile some[kTilesTogether];
  resolver.expect(tiles, first);
  for (std::size_t t = 0; t < tiles.size(); t += kTilesTogether) {
    const auto together = std::span(some).first(std::min(kTilesTogether, tiles.size() - t));
    resolver.expect(tiles.subspan(std::min(t + kTilesTogether, tiles.size())), first + (t + kTilesTogether) * kPacket);
    for (std::size_t k = 0; k < together.size(); ++k) {
      resolver.begin(tiles[t + k], first + (t + k) * kPacket, together[k]);
    }
    if (!job.field.shape.lists) resolver.settle(together);
    for (OpenTile& a : together) resolver.finish(a);
  }
  return resolver.counts();
}

}  // namespace scanmill
