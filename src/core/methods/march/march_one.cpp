#include <algorithm>
#include <bit>
#include <cmath>

#include "methods/march/march.h"
#include "methods/march/march_rule.h"

namespace scanmill {

namespace {

struct Voxel {
  float scale, grow;    // 2^-level, 2^level
  float fx, fy, fz;     // in the voxel, 0 to 1
  float rx, ry, rz;     // from the nearest corner
  std::uint32_t brick;  // full: index; else the bits of a distance
  bool full;
  std::uint32_t cell, nearest;  // corners' indices in the arrays of bricks; full only
  float bx, by, bz;             // from the brick's centre
};

Voxel find(const DistanceField& field, float x, float y, float z) {
  Voxel v;
  const std::int32_t index = levelAt(field, x, y, z);
  const FieldLevel& level = field.levels[static_cast<std::size_t>(index)];
  v.scale = std::bit_cast<float>(static_cast<std::uint32_t>(127 - index) << 23);
  v.grow = std::bit_cast<float>(static_cast<std::uint32_t>(127 + index) << 23);
  std::uint32_t brick[3];
  std::uint32_t in[3];
  float f[3];
  float b[3];
  const float q[3] = {x, y, z};
  for (int k = 0; k < 3; ++k) {
    const float u = std::max(q[k] * v.scale + level.offset[k], 0.0f);
    const auto corner = std::min(static_cast<std::int32_t>(u), static_cast<std::int32_t>(level.bricks[k]) * 8 - 1);
    brick[k] = static_cast<std::uint32_t>(corner) >> 3;
    in[k] = static_cast<std::uint32_t>(corner) & 7u;
    f[k] = u - static_cast<float>(corner);
    b[k] = u - static_cast<float>(static_cast<std::int32_t>(brick[k]) * 8 + 4);
  }
  const std::uint32_t entry =
      field.table[level.firstEntry + (brick[2] * level.bricks[1] + brick[1]) * level.bricks[0] + brick[0]];
  v.full = entry >= kFullBrick;
  v.brick = v.full ? entry - kFullBrick : entry;
  v.fx = f[0];
  v.fy = f[1];
  v.fz = f[2];
  v.bx = b[0];
  v.by = b[1];
  v.bz = b[2];
  const std::uint32_t up[3] = {f[0] >= 0.5f, f[1] >= 0.5f, f[2] >= 0.5f};
  v.rx = f[0] - static_cast<float>(up[0]);
  v.ry = f[1] - static_cast<float>(up[1]);
  v.rz = f[2] - static_cast<float>(up[2]);
  v.cell = v.full ? v.brick * kBrickStride + (in[2] * 9 + in[1]) * 9 + in[0] : 0;
  v.nearest = v.cell + (up[2] * 9 + up[1]) * 9 + up[0];
  return v;
}

// Of the particle's line and the free ball of this radius around a point: see march_rule.h.
struct Chord {
  float square;  // of the distance from the centre
  float along;   // from the ball's middle to the particle
  float half;    // at most half of the chord
};

Chord chordOf(float radius, float bend, float x, float y, float z, const Vec3f& d) {
  const float square = x * x + y * y + z * z;
  const float along = x * d.x + y * d.y + z * d.z;
  return {square, along, radius - (square - along * along) * bend};
}

float mix(float a, float b, float t) {
  return a + (b - a) * t;
}

// Trilinear, in voxels.
float interpolate(const DistanceField& field, const Voxel& v) {
  const auto row = [&](std::uint32_t at) {
    const std::uint32_t i = v.cell + at;
    return mix(static_cast<float>(field.distance[i]), static_cast<float>(field.distance[i + 1]), v.fx);
  };
  return mix(mix(row(0), row(9), v.fy), mix(row(81), row(90), v.fy), v.fz) * kDistanceStep;
}

// m from the particle's place, as a fraction.
struct Crossing {
  float numerator = 0;
  float denominator = 0;  // > 0 of a hit
  std::uint32_t triangle = 0;
};

Vec3f crossProduct(const Vec3f& a, const Vec3f& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

float dotProduct(const Vec3f& a, const Vec3f& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Moeller and Trumbore 1997, without the division.
void intersect(const TriangleBlock& block, std::uint32_t triangle, const Vec3f& place, const Vec3f& d, float low,
               float high, float tie, Crossing& best) {
  const Triangle& corners = block.corners[triangle];
  const Vec3f a = block.vertices[corners[0]];
  const Vec3f ab = block.vertices[corners[1]] - a;
  const Vec3f ac = block.vertices[corners[2]] - a;
  const Vec3f p = crossProduct(d, ac);
  const float determinant = dotProduct(ab, p);
  const float sign = determinant < 0 ? -1.0f : 1.0f;
  const Vec3f s = place - a;
  const Vec3f q = crossProduct(s, ab);
  const float whole = determinant * sign;
  const float u = dotProduct(s, p) * sign;
  const float v = dotProduct(d, q) * sign;
  const float t = dotProduct(ac, q) * sign;
  const float seam = whole * kSeam;
  if (!(whole > 0) || u < -seam || v < -seam || u + v > whole + seam) return;
  if (t < low * whole || t > high * whole) return;
  if (best.denominator > 0 && !(t * best.denominator < (best.numerator - tie * best.denominator) * whole)) return;
  best = {t, whole, triangle};
}

}  // namespace

void Particles::resize(std::size_t count, bool lists) {
  for (auto* column : {&ox, &oy, &oz, &dx, &dy, &dz, &begin, &end}) column->resize(count);
  for (auto* column : {&wx, &wy, &wz, &ix, &iy, &iz}) column->resize(lists ? count : 0);
}

void HitRecords::resize(std::size_t count) {
  way.resize(count);
  triangle.resize(count);
  outcome.resize(count);
}

double voxelAt(const DistanceField& field, const Vec3f& place) {
  const auto level = static_cast<std::uint32_t>(levelAt(field, place.x, place.y, place.z));
  return field.shape.voxel * double{std::bit_cast<float>((127 + level) << 23)};
}

FieldPlace placeIn(const DistanceField& field, const Vec3f& place) {
  const Voxel v = find(field, place.x, place.y, place.z);
  const double voxel = field.shape.voxel * double{v.grow};
  if (!v.full)
    return {std::bit_cast<float>(v.brick) - std::sqrt(v.bx * v.bx + v.by * v.by + v.bz * v.bz), kNoWord, voxel};
  return {interpolate(field, v), field.shape.lists ? kNoWord : field.word[v.nearest], voxel};
}

std::uint32_t voxelCorner(const DistanceField& field, const Vec3f& place) {
  const Voxel v = find(field, place.x, place.y, place.z);
  return v.full ? v.cell : kNoWord;
}

std::uint32_t nearestCorner(const DistanceField& field, const Vec3f& place) {
  const Voxel v = find(field, place.x, place.y, place.z);
  return v.full ? v.nearest : kNoWord;
}

HitRecord marchOne(const DistanceField& field, const TriangleBlock& triangles, const MarchOptions& options,
                   const Particles& particles, std::size_t i) {
  const Vec3f o{particles.ox[i], particles.oy[i], particles.oz[i]};
  const Vec3f d{particles.dx[i], particles.dy[i], particles.dz[i]};
  const auto metres = static_cast<float>(field.shape.voxel);
  const float begin = particles.begin[i];
  const float end = particles.end[i];
  float clear = begin;  // the way is free up to here
  float way = begin;    // where the particle looks
  float last = kNever;  // the interpolated distance of the step before
  float lastWay = 0;
  std::uint32_t lastNearest = 0;
  for (std::uint32_t step = 0; step < options.steps; ++step) {
    if (!(clear < end)) return {0, 0, Outcome::Miss, step};
    const Voxel v = find(field, o.x + d.x * way, o.y + d.y * way, o.z + d.z * way);
    // Voxels of the level.
    float ahead = 0;  // free from the particle on
    float back = 0;   // and behind it
    float leap = 0;
    float seen = kNever;
    bool rests = false;
    bool listed = false;
    if (!v.full) {
      const Chord chord = chordOf(std::bit_cast<float>(v.brick), kEmptyBend, v.bx, v.by, v.bz, d);
      ahead = chord.half - chord.along;
      back = chord.half + chord.along;
      leap = kLeap;
    } else {
      const float near = static_cast<float>(field.distance[v.nearest]) * kDistanceStep;
      const bool far = near > kNamed;
      const Chord chord = chordOf(near, far ? kNamedBend : kListedBend, v.rx, v.ry, v.rz, d);
      leap = far ? kLeap : 0.0f;
      if (!field.shape.lists) {
        if (far) {
          ahead = chord.half - chord.along;
          back = chord.half + chord.along;
        } else {
          const float here = interpolate(field, v);
          rests = here <= std::min(std::max(options.hit, options.cone * way * v.scale), kWidestHit);
          ahead = here;
          seen = here;
        }
      } else {
        const auto face = [](float r, float inverse) { return ((inverse < 0 ? -kFace : kFace) - r) * inverse; };
        const float exit =
            std::min(face(v.rx, particles.ix[i]), std::min(face(v.ry, particles.iy[i]), face(v.rz, particles.iz[i])));
        if (near > kListed) {
          ahead = std::max(chord.half - chord.along, exit);
          back = chord.half + chord.along;
        } else {
          // The part of the way that is in the voxel is free if the corner's ball holds both of its ends.
          const float out = chord.square + (2 * chord.along + exit) * exit;
          const float ball = near * near;
          listed = chord.square > ball || out > ball;
          ahead = exit;
        }
      }
    }
    if (way - back * v.grow > clear) {
      way = clear;
      continue;
    }
    if (rests) return {way, field.word[v.nearest], Outcome::Hit, step + 1};
    if (last <= kGrazing && !(seen < last)) return {lastWay, field.word[lastNearest], Outcome::Grazing, step + 1};
    last = seen;
    lastWay = way;
    lastNearest = v.nearest;
    if (listed) {
      const float voxel = metres * v.grow;
      const Vec3f place{particles.wx[i] + d.x * (way * metres), particles.wy[i] + d.y * (way * metres),
                        particles.wz[i] + d.z * (way * metres)};
      const float low = std::max(-kBehind * voxel, (begin - way) * metres);
      const float high = (ahead + kNudge) * voxel;
      Crossing best;
      std::uint32_t at = field.word[v.nearest];
      for (bool more = at != kNoWord; more; ++at) {
        const std::uint32_t entry = field.lists[at];
        more = entry < kLastOfList;
        intersect(triangles, entry & ~kLastOfList, place, d, low, high, kTie * voxel, best);
      }
      if (best.denominator > 0) {
        return {way + best.numerator / (best.denominator * metres), best.triangle, Outcome::Hit, step + 1};
      }
    }
    const float stride = ahead * v.grow;
    clear = way + stride;
    way = std::min(clear + stride * leap, end);
  }
  return {0, 0, Outcome::Exhausted, options.steps};
}

}  // namespace scanmill
