#include "methods/ray_tracing/packet.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "scene/texture.h"

namespace scanmill {

namespace {

using Lane = double[kPacket];

// Origins and directions of the beams, in double, relative to the world's origin.
struct Rays {
  int count = 0;
  alignas(64) Lane ox, oy, oz, dx, dy, dz;
};

// The hit triangles' corners, likewise, and what was asked of them.
struct Resolved {
  alignas(64) Lane ax, ay, az, bx, by, bz, cx, cy, cz;
  alignas(64) Lane nx, ny, nz;  // not normalised
  alignas(64) Lane present;     // 1 where the lane hit a triangle, else 0
  alignas(64) Lane range;       // m; infinite for a miss
  alignas(64) Lane cosine;      // of normal and beam, times length
  alignas(64) Lane length;      // of the normal
};

void setUp(const PacketJob& job, const Tile& tile, Rays& rays) {
  const Shot& shot = job.shot;
  const BeamTable& beams = *shot.beams;
  int lane = 0;
  for (std::uint32_t r = 0; r < tile.rows; ++r) {
    const std::uint32_t first = (tile.ring + r) * beams.columns + tile.column;
    for (std::uint32_t c = 0; c < tile.width; ++c, ++lane) {
      const std::size_t step = job.frame.rotation.size() == 1 ? 0 : shot.stepOf(tile.column + c);
      const Mat3& rotation = job.frame.rotation[step];
      const Vec3d d = rotation * beams.direction[first + c];
      Vec3d o = job.frame.position[step];
      if (!beams.origin.empty()) o += rotation * Vec3d(beams.origin[first + c]);
      rays.ox[lane] = o.x;
      rays.oy[lane] = o.y;
      rays.oz[lane] = o.z;
      rays.dx[lane] = d.x;
      rays.dy[lane] = d.y;
      rays.dz[lane] = d.z;
    }
  }
  rays.count = lane;
  for (; lane < kPacket; ++lane) {  // idle lanes repeat the first beam
    rays.ox[lane] = rays.ox[0];
    rays.oy[lane] = rays.oy[0];
    rays.oz[lane] = rays.oz[0];
    rays.dx[lane] = rays.dx[0];
    rays.dy[lane] = rays.dy[0];
    rays.dz[lane] = rays.dz[0];
  }
}

// Embree searches a little past the maximum: its float32 distance must not decide what lies at exactly the maximum.
float searchDistance(const BeamTable& beams) {
  return static_cast<float>(beams.maxRange * (1 + 1e-4) + 1e-3);
}

void intersectAll(const PacketJob& job, const Rays& rays, TieContext& context) {
  RTCRayHit16 packet;
  alignas(64) int valid[kPacket];
  const float far = searchDistance(*job.shot.beams);
  for (int i = 0; i < kPacket; ++i) {
    packet.ray.org_x[i] = static_cast<float>(rays.ox[i]);
    packet.ray.org_y[i] = static_cast<float>(rays.oy[i]);
    packet.ray.org_z[i] = static_cast<float>(rays.oz[i]);
    packet.ray.dir_x[i] = static_cast<float>(rays.dx[i]);
    packet.ray.dir_y[i] = static_cast<float>(rays.dy[i]);
    packet.ray.dir_z[i] = static_cast<float>(rays.dz[i]);
    packet.ray.tnear[i] = 0;
    packet.ray.tfar[i] = far;
    packet.ray.time[i] = 0;
    packet.ray.mask[i] = ~0u;
    packet.ray.id[i] = static_cast<unsigned>(i);
    packet.ray.flags[i] = 0;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    valid[i] = i < rays.count ? -1 : 0;
  }
  context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, job.world.embree.get(), &context.embree, &packet);
}

void intersectEach(const PacketJob& job, const Rays& rays, TieContext& context) {
  for (int i = 0; i < rays.count; ++i) {
    RTCRayHit one;
    one.ray = {static_cast<float>(rays.ox[i]),  static_cast<float>(rays.oy[i]),
               static_cast<float>(rays.oz[i]),  0,
               static_cast<float>(rays.dx[i]),  static_cast<float>(rays.dy[i]),
               static_cast<float>(rays.dz[i]),  0,
               searchDistance(*job.shot.beams), ~0u,
               static_cast<unsigned>(i),        0};
    one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(job.world.embree.get(), &context.embree, &one);
  }
}

struct HitTriangle {
  const TriangleBlock* block = nullptr;  // null: a miss
  const PlacedBlock* placed = nullptr;   // null: baked
  std::uint32_t index = 0;
};

HitTriangle triangleOf(const World& world, const TieContext& context, int lane) {
  if (!(context.distance[lane] < INFINITY)) return {};
  const std::uint32_t instance = context.instance[lane];
  const PlacedBlock* placed =
      instance == RTC_INVALID_GEOMETRY_ID ? nullptr : &world.placed[instance - World::kFirstPlaced];
  const TriangleBlock* block = placed == nullptr ? &world.baked : placed->block;
  return {block, placed, block->global(context.geometry[lane], context.primitive[lane])};
}

void loadCorners(const HitTriangle& triangle, Resolved& r, int lane) {
  const Triangle& corners = triangle.block->triangles[triangle.index].corners;
  Vec3d a = triangle.block->vertex(corners[0]);
  Vec3d b = triangle.block->vertex(corners[1]);
  Vec3d c = triangle.block->vertex(corners[2]);
  if (triangle.placed != nullptr) {
    a = triangle.placed->originFromMesh * a;
    b = triangle.placed->originFromMesh * b;
    c = triangle.placed->originFromMesh * c;
  }
  r.ax[lane] = a.x;
  r.ay[lane] = a.y;
  r.az[lane] = a.z;
  r.bx[lane] = b.x;
  r.by[lane] = b.y;
  r.bz[lane] = b.z;
  r.cx[lane] = c.x;
  r.cy[lane] = c.y;
  r.cz[lane] = c.z;
  r.present[lane] = 1;
}

// Any triangle will do where a lane missed.
void loadNothing(Resolved& r, int lane) {
  for (double* corner : {r.ax, r.ay, r.az, r.bx, r.by, r.bz, r.cx, r.cy, r.cz, r.present}) corner[lane] = 0;
}

// Distance along each ray to the plane of its triangle, kept within the triangle's own extent along the ray: where the
// triangle is seen edge-on the plane says little. All lanes at once, in double.
void intersectPlanes(const Rays& rays, const BeamTable& beams, Resolved& r) {
  const double nearest = beams.minRange > 0 ? beams.minRange : std::numeric_limits<double>::denorm_min();
  const double farthest = beams.maxRange * (1 + 1e-12);
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kPacket; ++i) {
    const double ux = r.bx[i] - r.ax[i];
    const double uy = r.by[i] - r.ay[i];
    const double uz = r.bz[i] - r.az[i];
    const double vx = r.cx[i] - r.ax[i];
    const double vy = r.cy[i] - r.ay[i];
    const double vz = r.cz[i] - r.az[i];
    const double nx = uy * vz - uz * vy;
    const double ny = uz * vx - ux * vz;
    const double nz = ux * vy - uy * vx;
    const double sx = r.ax[i] - rays.ox[i];
    const double sy = r.ay[i] - rays.oy[i];
    const double sz = r.az[i] - rays.oz[i];
    const double along = nx * rays.dx[i] + ny * rays.dy[i] + nz * rays.dz[i];
    const double toA = sx * rays.dx[i] + sy * rays.dy[i] + sz * rays.dz[i];
    const double toB = toA + (ux * rays.dx[i] + uy * rays.dy[i] + uz * rays.dz[i]);
    const double toC = toA + (vx * rays.dx[i] + vy * rays.dy[i] + vz * rays.dz[i]);
    double low = toA < toB ? toA : toB;
    low = low < toC ? low : toC;
    double high = toA > toB ? toA : toB;
    high = high > toC ? high : toC;
    const double plane = (nx * sx + ny * sy + nz * sz) / along;
    double range = plane > low ? plane : low;  // also where plane is NaN
    range = range < high ? range : high;
    const bool inside = (range >= nearest) & (range <= farthest) & (r.present[i] > 0);
    r.range[i] = inside ? range : kNothing;
    r.nx[i] = nx;
    r.ny[i] = ny;
    r.nz[i] = nz;
    r.cosine[i] = along;
    r.length[i] = nx * nx + ny * ny + nz * nz;
  }
  for (int i = 0; i < kPacket; ++i) r.length[i] = std::sqrt(r.length[i]);
}

// Base colour's linear luminance over the texture's mean, times the material's reflectance.
float texturedReflectance(const HitTriangle& triangle, const CompactMaterial& material, const Rays& rays,
                          const Resolved& r, int i) {
  const Vec3d n{r.nx[i], r.ny[i], r.nz[i]};
  const Vec3d a{r.ax[i], r.ay[i], r.az[i]};
  const Vec3d p =
      Vec3d{rays.ox[i], rays.oy[i], rays.oz[i]} + Vec3d{rays.dx[i], rays.dy[i], rays.dz[i]} * r.range[i] - a;
  const Vec3d ab = Vec3d{r.bx[i], r.by[i], r.bz[i]} - a;
  const Vec3d ac = Vec3d{r.cx[i], r.cy[i], r.cz[i]} - a;
  const double square = dot(n, n);
  const double u = std::clamp(dot(n, cross(p, ac)) / square, 0.0, 1.0);
  const double v = std::clamp(dot(n, cross(ab, p)) / square, 0.0, 1.0 - u);
  const std::uint8_t* texel = texelAt(*triangle.block, triangle.index, *material.texture, u, v);
  return std::min(1.0f, material.textureGain * luminance(texel));
}

// Copies one value per lane into an image, row by row of the tile.
template <class T>
void storeRows(const Tile& tile, const T* lanes, std::vector<T>& column, std::uint32_t columns) {
  for (std::uint32_t r = 0; r < tile.rows; ++r) {
    std::copy_n(lanes + r * tile.width, tile.width, &column[std::size_t{tile.ring + r} * columns + tile.column]);
  }
}

// What the triangles say of the lanes' hits.
struct Looked {
  std::uint32_t instance[kPacket];
  std::uint16_t semantic[kPacket];
  std::uint16_t material[kPacket];
  std::uint32_t primitive[kPacket];
};

void lookUp(const HitTriangle* triangles, const float* range, Looked& looked) {
  for (int i = 0; i < kPacket; ++i) {
    HitSurface surface{};
    std::uint32_t primitive = 0;
    if (range[i] < kMiss) {
      const HitTriangle& t = triangles[i];
      const BlockTriangle& triangle = t.block->triangles[t.index];
      surface = t.block->surfaces[triangle.surface];
      primitive = triangle.primitive;
      if (t.placed != nullptr && surface.instance != 0) surface.instance += t.placed->firstInstanceId - 1;
    }
    looked.instance[i] = surface.instance;
    looked.semantic[i] = surface.semantic;
    looked.material[i] = surface.material;
    looked.primitive[i] = primitive;
  }
}

void storeReflectance(const PacketJob& job, const Tile& tile, const Rays& rays, const Resolved& r,
                      const HitTriangle* triangles, const float* range, const Looked& looked, Hits& hits) {
  float reflectance[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const CompactMaterial& material = job.materials[looked.material[i]];
    reflectance[i] = range[i] < kMiss ? material.reflectance : 0.0f;
    if (range[i] < kMiss && material.texture != nullptr) {
      reflectance[i] = texturedReflectance(triangles[i], material, rays, r, i);
    }
  }
  storeRows(tile, reflectance, hits.reflectance, hits.columns);
}

void storeIncidence(const Tile& tile, const Resolved& r, Hits& hits) {
  alignas(64) float incidence[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const double cosine = std::abs(r.cosine[i]) / r.length[i];
    const double bounded = cosine < 1 ? cosine : 1;
    incidence[i] = static_cast<float>(r.range[i] < kMiss ? bounded : 0);
  }
  storeRows(tile, incidence, hits.incidence, hits.columns);
}

void storeNormals(const Tile& tile, const Resolved& r, Hits& hits) {
  alignas(64) float x[kPacket], y[kPacket], z[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const double towards = (r.cosine[i] > 0 ? -1 : 1) / r.length[i];
    const double scale = r.range[i] < kMiss ? towards : 0;
    x[i] = static_cast<float>(r.nx[i] * scale);
    y[i] = static_cast<float>(r.ny[i] * scale);
    z[i] = static_cast<float>(r.nz[i] * scale);
  }
  Vec3f normal[kPacket];
  for (int i = 0; i < kPacket; ++i) normal[i] = {x[i], y[i], z[i]};
  storeRows(tile, normal, hits.normal, hits.columns);
}

void store(const PacketJob& job, const Tile& tile, const Rays& rays, const Resolved& r, const HitTriangle* triangles,
           Hits& hits) {
  const Channels asked = hits.channels;
  alignas(64) float range[kPacket];
  for (int i = 0; i < kPacket; ++i) range[i] = static_cast<float>(r.range[i]);
  storeRows(tile, range, hits.range, hits.columns);
  if (asked.has(Channel::Incidence)) storeIncidence(tile, r, hits);
  if (asked.has(Channel::Normal)) storeNormals(tile, r, hits);
  Looked looked;
  lookUp(triangles, range, looked);
  if (asked.has(Channel::Instance)) storeRows(tile, looked.instance, hits.instance, hits.columns);
  if (asked.has(Channel::Semantic)) storeRows(tile, looked.semantic, hits.semantic, hits.columns);
  if (asked.has(Channel::Material)) storeRows(tile, looked.material, hits.material, hits.columns);
  if (asked.has(Channel::Primitive)) storeRows(tile, looked.primitive, hits.primitive, hits.columns);
  if (asked.has(Channel::Reflectance)) storeReflectance(job, tile, rays, r, triangles, range, looked, hits);
}

// A packet on its way: traced, then its triangles' records on their way to the caches, then their corners, then
// resolved.
struct Pending {
  Tile tile;
  Rays rays;
  HitTriangle triangles[kPacket];
};

void begin(const PacketJob& job, const Tile& tile, Pending& p) {
  p.tile = tile;
  setUp(job, tile, p.rays);
  TieContext context;
  rtcInitIntersectContext(&context.embree);
  context.world = &job.world;
  context.floor = job.coplanarFloor;
  context.reset();
  if (job.raysPerCall == 1) {
    intersectEach(job, p.rays, context);
  } else {
    intersectAll(job, p.rays, context);
  }
  for (int i = 0; i < kPacket; ++i) {
    p.triangles[i] = i < p.rays.count ? triangleOf(job.world, context, i) : HitTriangle{};
    if (p.triangles[i].block != nullptr) __builtin_prefetch(&p.triangles[i].block->triangles[p.triangles[i].index]);
  }
}

void fetchCorners(const Pending& p) {
  for (int i = 0; i < p.rays.count; ++i) {
    const HitTriangle& t = p.triangles[i];
    if (t.block == nullptr) continue;
    const BlockTriangle& triangle = t.block->triangles[t.index];
    for (const std::uint32_t corner : triangle.corners) t.block->prefetchVertex(corner);
    __builtin_prefetch(&t.block->surfaces[triangle.surface]);
  }
}

void finish(const PacketJob& job, const Pending& p, Hits& hits) {
  Resolved resolved;
  for (int i = 0; i < kPacket; ++i) {
    if (p.triangles[i].block != nullptr) {
      loadCorners(p.triangles[i], resolved, i);
    } else {
      loadNothing(resolved, i);
    }
  }
  intersectPlanes(p.rays, *job.shot.beams, resolved);
  store(job, p.tile, p.rays, resolved, p.triangles, hits);
}

}  // namespace

void tracePackets(const PacketJob& job, std::span<const Tile> tiles, Hits& hits) {
  // Three packets in flight: while Embree traces one, what resolving the two before it reads comes from memory.
  constexpr std::size_t kInFlight = 3;
  Pending pending[kInFlight];
  for (std::size_t i = 0; i < tiles.size() + kInFlight - 1; ++i) {
    if (i < tiles.size()) begin(job, tiles[i], pending[i % kInFlight]);
    if (i >= 1 && i - 1 < tiles.size()) fetchCorners(pending[(i - 1) % kInFlight]);
    if (i >= 2) finish(job, pending[(i - 2) % kInFlight], hits);
  }
}

}  // namespace scanmill
