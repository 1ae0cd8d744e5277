#include "methods/ray_tracing/packet.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "scene/assets/texture.h"

namespace scanmill {

namespace {

using Lane = double[kPacket];

// Origins and directions of the beams, in double, relative to the world's origin.
struct Rays {
  int count = 0;
  alignas(64) Lane ox, oy, oz, dx, dy, dz;
};

// The planes of the hit triangles, likewise, and what was asked of them.
struct Resolved {
  alignas(64) Lane nx, ny, nz;  // unit normals
  alignas(64) Lane offset;      // normal . p of the plane
  alignas(64) Lane traced;      // m, Embree's distance; infinite for a miss
  alignas(64) Lane range;       // m; infinite for a miss
  alignas(64) Lane cosine;      // of normal and beam, signed
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

void loadPlane(const HitTriangle& hit, float traced, Resolved& r, int lane) {
  const BlockTriangle& triangle = hit.block->triangles[hit.index];
  Vec3d normal = triangle.normal;
  double offset = triangle.offset;
  if (hit.placed != nullptr) {
    normal = hit.placed->normalFromMesh * normal;
    const double scale = 1 / length(normal);
    normal = normal * scale;
    offset = offset * scale + dot(normal, hit.placed->originFromMesh.translation);
  }
  r.nx[lane] = normal.x;
  r.ny[lane] = normal.y;
  r.nz[lane] = normal.z;
  r.offset[lane] = offset;
  r.traced[lane] = double{traced};
}

void loadMiss(Resolved& r, int lane) {
  r.nx[lane] = r.ny[lane] = r.nz[lane] = r.offset[lane] = 0;
  r.traced[lane] = std::numeric_limits<double>::infinity();
}

// How far the distance to a plane may lie from Embree's: seen edge-on, a plane says little of where its triangle is.
constexpr double kTrust = 1e-2;  // of the distance, and m

// Distance along each ray to the plane of its triangle, all lanes at once, in double.
void intersectPlanes(const Rays& rays, const BeamTable& beams, Resolved& r) {
  const double nearest = beams.minRange > 0 ? beams.minRange : std::numeric_limits<double>::denorm_min();
  const double farthest = beams.maxRange * (1 + 1e-12);
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kPacket; ++i) {
    const double along = r.nx[i] * rays.dx[i] + r.ny[i] * rays.dy[i] + r.nz[i] * rays.dz[i];
    const double origin = r.nx[i] * rays.ox[i] + r.ny[i] * rays.oy[i] + r.nz[i] * rays.oz[i];
    const double plane = (r.offset[i] - origin) / along;
    const double low = r.traced[i] - (kTrust * r.traced[i] + kTrust);
    const double high = r.traced[i] + (kTrust * r.traced[i] + kTrust);
    double range = plane > low ? plane : low;  // also where plane is NaN
    range = range < high ? range : high;
    const bool inside = (range >= nearest) & (range <= farthest) & (r.traced[i] < kNothing);
    r.range[i] = inside ? range : kNothing;
    r.cosine[i] = along;
  }
}

// Base colour's linear luminance over the texture's mean, times the material's reflectance.
float texturedReflectance(const HitTriangle& hit, const CompactMaterial& material, const Rays& rays, const Resolved& r,
                          int i) {
  const Triangle& corners = hit.block->corners[hit.index];
  const auto corner = [&](int k) {
    const Vec3d p(hit.block->vertices[corners[k]]);
    return hit.placed == nullptr ? p : hit.placed->originFromMesh * p;
  };
  const Vec3d a = corner(0);
  const Vec3d ab = corner(1) - a;
  const Vec3d ac = corner(2) - a;
  const Vec3d n = cross(ab, ac);
  const Vec3d p =
      Vec3d{rays.ox[i], rays.oy[i], rays.oz[i]} + Vec3d{rays.dx[i], rays.dy[i], rays.dz[i]} * r.range[i] - a;
  const double square = dot(n, n);
  const double u = std::clamp(dot(n, cross(p, ac)) / square, 0.0, 1.0);
  const double v = std::clamp(dot(n, cross(ab, p)) / square, 0.0, 1.0 - u);
  const std::uint8_t* texel = texelAt(*hit.block, hit.index, *material.texture, u, v);
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
    const double cosine = std::abs(r.cosine[i]);
    const double bounded = cosine < 1 ? cosine : 1;
    incidence[i] = static_cast<float>(r.range[i] < kMiss ? bounded : 0);
  }
  storeRows(tile, incidence, hits.incidence, hits.columns);
}

void storeNormals(const Tile& tile, const Resolved& r, Hits& hits) {
  alignas(64) float x[kPacket], y[kPacket], z[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const double towards = r.cosine[i] > 0 ? -1 : 1;
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

// A packet on its way: traced, while its triangles' records come to the caches; then resolved.
struct Pending {
  Tile tile;
  Rays rays;
  HitTriangle triangles[kPacket];
  float traced[kPacket];  // m
};

// A record may lie across two cache lines.
void prefetch(const BlockTriangle& triangle) {
  const auto* bytes = reinterpret_cast<const char*>(&triangle);
  __builtin_prefetch(bytes);
  __builtin_prefetch(bytes + sizeof triangle - 1);
}

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
    p.traced[i] = context.distance[i];
    if (p.triangles[i].block != nullptr) prefetch(p.triangles[i].block->triangles[p.triangles[i].index]);
  }
}

void finish(const PacketJob& job, const Pending& p, Hits& hits) {
  Resolved resolved;
  for (int i = 0; i < kPacket; ++i) {
    if (p.triangles[i].block != nullptr) {
      loadPlane(p.triangles[i], p.traced[i], resolved, i);
    } else {
      loadMiss(resolved, i);
    }
  }
  intersectPlanes(p.rays, *job.shot.beams, resolved);
  store(job, p.tile, p.rays, resolved, p.triangles, hits);
}

}  // namespace

void tracePackets(const PacketJob& job, std::span<const Tile> tiles, Hits& hits) {
  // Two packets in flight: while Embree traces one, what resolving the other reads comes from memory.
  Pending pending[2];
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    begin(job, tiles[i], pending[i % 2]);
    if (i > 0) finish(job, pending[(i - 1) % 2], hits);
  }
  if (!tiles.empty()) finish(job, pending[(tiles.size() - 1) % 2], hits);
}

}  // namespace scanmill
