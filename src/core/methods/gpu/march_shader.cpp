#include <fmt/format.h>

#include "gpu/compute.h"
#include "methods/field/distance_field.h"
#include "methods/field/march_rule.h"
#include "methods/field/particle_launch.h"
#include "methods/gpu/device_beams.h"
#include "methods/gpu/march_gl.h"

namespace scanmill {

namespace {

// Takes the steps of march_stream.h. What is `precise` is neither contracted nor reassociated, so it has the same bits
// as on the processor. Divisions, which GPUs round differently, are left to the processor.
constexpr const char* kCommon = R"(
layout(std140, binding = 0) uniform MarchParameters {
  int lastLevel;
  float perReach;
  float metres;
  uint steps;
  uint count;
  uint again;  // 1: marches only those that continue behind a hole
};
layout(std430, binding = 0) readonly restrict buffer Particles { float particles[]; };
layout(std430, binding = 1) restrict buffer HitRecords { uint records[]; };
layout(binding = 0) uniform usamplerBuffer levels;
layout(binding = 1) uniform usamplerBuffer table;
layout(binding = 2) uniform usamplerBuffer distances;
layout(binding = 3) uniform usamplerBuffer words;

uint fetch(usamplerBuffer from, uint i) {
  return texelFetch(from, int(i)).x;
}

vec3 column3(uint column, uint i) {
  return vec3(particles[column * count + i], particles[(column + 1u) * count + i],
              particles[(column + 2u) * count + i]);
}

void record(uint i, float way, uint triangle, uint outcome) {
  records[i] = floatBitsToUint(way);
  records[count + i] = triangle;
  records[2u * count + i] = outcome;
}

struct Voxel {
  float scale, grow;
  vec3 f;  // in the voxel
  vec3 r;  // from the nearest corner
  vec3 b;  // from the brick's centre
  bool full;
  uint brick, cell, nearest;
};

Voxel find(vec3 q) {
  precise float most = max(abs(q.x), max(abs(q.y), abs(q.z)));
  precise float share = most * perReach;
  int level = min(max((int(floatBitsToUint(share) - 1u) >> 23) - 126, 0), lastLevel);
  uvec4 place = texelFetch(levels, 2 * level);  // bits of the offset, and the first entry of the table
  uvec4 box = texelFetch(levels, 2 * level + 1);
  Voxel v;
  v.scale = uintBitsToFloat(uint(127 - level) << 23);
  v.grow = uintBitsToFloat(uint(127 + level) << 23);
  precise vec3 u = max(q * v.scale + uintBitsToFloat(place.xyz), vec3(0.0));
  ivec3 corner = min(ivec3(u), ivec3(box.xyz) * 8 - 1);
  uvec3 brick = uvec3(corner) >> 3u;
  uvec3 at = uvec3(corner) & 7u;
  precise vec3 f = u - vec3(corner);
  precise vec3 b = u - vec3(ivec3(brick) * 8 + 4);
  bvec3 above = greaterThanEqual(f, vec3(0.5));
  precise vec3 r = f - vec3(above);
  uvec3 up = uvec3(above);
  uint entry = fetch(table, place.w + (brick.z * box.y + brick.y) * box.x + brick.x);
  v.f = f;
  v.b = b;
  v.r = r;
  v.full = entry >= kFullBrick;
  v.brick = v.full ? entry - kFullBrick : entry;
  v.cell = v.full ? v.brick * kBrickStride + (at.z * 9u + at.y) * 9u + at.x : 0u;
  v.nearest = v.cell + (up.z * 9u + up.y) * 9u + up.x;
  return v;
}

float distanceAt(uint corner) {
  return float(fetch(distances, corner));
}

float dotted(vec3 a, vec3 b) {
  precise float product = a.x * b.x + a.y * b.y + a.z * b.z;
  return product;
}

struct Chord {
  float square;  // of the distance from the centre
  float along;   // from the ball's middle to the particle
  float across;  // at most half of the chord
};

Chord chordOf(float radius, float bend, vec3 r, vec3 d) {
  precise float square = dotted(r, r);
  precise float along = dotted(r, d);
  precise float most = radius - (square - along * along) * bend;
  return Chord(square, along, most);
}
)";

constexpr const char* kNearest = R"(
float mixed(float a, float b, float t) {
  precise float between = a + (b - a) * t;
  return between;
}

float row(uint i, float t) {
  return mixed(distanceAt(i), distanceAt(i + 1u), t);
}

float interpolate(Voxel v) {
  precise float below = mixed(row(v.cell, v.f.x), row(v.cell + 9u, v.f.x), v.f.y);
  precise float above = mixed(row(v.cell + 81u, v.f.x), row(v.cell + 90u, v.f.x), v.f.y);
  precise float here = mixed(below, above, v.f.z) * kDistanceStep;
  return here;
}

void invoke(uint i) {
  precise vec3 o = column3(0u, i);
  precise vec3 d = column3(3u, i);
  precise float way = particles[6u * count + i];
  precise float end = particles[7u * count + i];
  for (uint taken = 0u; taken < steps; ++taken) {
    if (!(way < end)) {
      record(i, 0.0, 0u, kMiss + 4u * taken);
      return;
    }
    precise vec3 q = o + d * way;
    Voxel v = find(q);
    precise float ahead;
    precise float near = v.full ? distanceAt(v.nearest) * kDistanceStep : uintBitsToFloat(v.brick);
    if (near > kNamed) {
      Chord chord = chordOf(near, v.full ? kNamedBend : kEmptyBend, v.full ? v.r : v.b, d);
      ahead = chord.across - chord.along;
    } else {
      ahead = interpolate(v);
      if (ahead <= kRest) {
        record(i, way, fetch(words, v.nearest), kHit + 4u * (taken + 1u));
        return;
      }
    }
    precise float stride = ahead * v.grow;
    way = way + stride;
  }
  record(i, 0.0, 0u, kExhausted + 4u * steps);
}
)";

// Particles march until all that run together have reached triangles, and then test their triangles together.
constexpr const char* kLists = R"(
layout(binding = 4) uniform usamplerBuffer lists;
layout(binding = 5) uniform samplerBuffer triangles;

vec3 crossed(vec3 a, vec3 b) {
  precise vec3 product = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return product;
}

struct Facet {
  vec3 a, ab, ac;  // a corner and the edges from it, m
};

Facet facetOf(uint triangle) {
  int at = int(3u * triangle);
  return Facet(texelFetch(triangles, at).xyz, texelFetch(triangles, at + 1).xyz, texelFetch(triangles, at + 2).xyz);
}

// The nearest triangle of a list that a particle hits in a voxel.
struct Search {
  vec3 d, place;    // m, where the particle enters the voxel
  float low, high;  // m from there, between which a hit counts
  float tie;        // m
  float numerator, denominator;  // of the way to the hit, m; denominator 0: no hit
  uint triangle;
};

void meet(inout Search found, uint triangle, Facet facet) {
  precise vec3 p = crossed(found.d, facet.ac);
  precise float determinant = dotted(facet.ab, p);
  precise float facing = determinant < 0.0 ? -1.0 : 1.0;
  precise vec3 s = found.place - facet.a;
  precise vec3 q = crossed(s, facet.ab);
  precise float whole = determinant * facing;
  precise float u = dotted(s, p) * facing;
  precise float v = dotted(found.d, q) * facing;
  precise float t = dotted(facet.ac, q) * facing;
  precise float seam = whole * kSeam;
  precise float corner = u + v;
  precise float most = whole + seam;
  precise float nearer = (found.numerator - found.tie * found.denominator) * whole;
  precise float here = t * found.denominator;
  precise float first = found.low * whole;
  precise float last = found.high * whole;
  if (whole > 0.0 && u >= -seam && v >= -seam && corner <= most && t >= first && t <= last &&
      (!(found.denominator > 0.0) || here < nearer)) {
    found.numerator = t;
    found.denominator = whole;
    found.triangle = triangle;
  }
}

void invoke(uint i) {
  precise vec3 o = column3(0u, i);
  precise vec3 d = column3(3u, i);
  precise float begin = particles[6u * count + i];
  precise float end = particles[7u * count + i];
  precise vec3 w = column3(8u, i);
  precise vec3 reciprocal = column3(11u, i);
  precise vec3 side = mix(vec3(kFace), vec3(-kFace), lessThan(reciprocal, vec3(0.0)));
  precise float way = begin;
  uint taken = 0u;
  if (again != 0u) {
    uint before = records[2u * count + i];
    if ((before & 3u) != kGoOn) return;
    taken = before >> 2;
  }
  while (true) {
    precise float ahead = 0.0;
    float grow = 1.0;
    uint word = kNoWord;
    bool listed = false;
    while (!listed) {
      if (taken >= steps || !(way < end)) {
        record(i, 0.0, 0u, taken < steps ? kMiss + 4u * taken : kExhausted + 4u * steps);
        return;
      }
      ++taken;
      precise vec3 q = o + d * way;
      Voxel v = find(q);
      precise float near = v.full ? distanceAt(v.nearest) * kDistanceStep : uintBitsToFloat(v.brick);
      precise vec3 r = v.full ? v.r : v.b;
      Chord chord = chordOf(near, v.full ? (near > kNamed ? kNamedBend : kListedBend) : kEmptyBend, r, d);
      ahead = chord.across - chord.along;
      grow = v.grow;
      if (v.full) {
        precise vec3 faces = (side - v.r) * reciprocal;
        precise float exit = min(faces.x, min(faces.y, faces.z));
        if (near > kListed) {
          ahead = max(ahead, exit);
        } else {
          precise float leaving = chord.square + (2.0 * chord.along + exit) * exit;
          precise float ball = near * near;
          listed = chord.square > ball || leaving > ball;
          ahead = exit;
        }
      }
      if (listed) {
        word = fetch(words, v.nearest);
      } else {
        precise float stride = ahead * grow;
        way = way + stride;
      }
    }
    precise float voxel = metres * grow;
    precise vec3 place = w + d * (way * metres);
    precise float low = max(-kBehind * voxel, (begin - way) * metres);
    precise float high = (ahead + kNudge) * voxel;
    precise float tie = kTie * voxel;
    Search found = Search(d, place, low, high, tie, 0.0, 0.0, 0u);
    bool more = word != kNoWord;
    while (more) {
      // Reads four entries at a time: devices mostly wait for memory, and these loads do not wait for each other.
      // Entries beyond the end of the list are ignored.
      uvec4 entries = uvec4(fetch(lists, word), fetch(lists, word + 1u), fetch(lists, word + 2u), fetch(lists, word + 3u));
      word += 4u;
      uvec4 numbers = entries & ~kLastOfList;
      Facet facets[4] = Facet[](facetOf(numbers.x), facetOf(numbers.y), facetOf(numbers.z), facetOf(numbers.w));
      bvec4 last = greaterThanEqual(entries, uvec4(kLastOfList));
      meet(found, numbers.x, facets[0]);
      if (!last.x) meet(found, numbers.y, facets[1]);
      if (!any(last.xy)) meet(found, numbers.z, facets[2]);
      if (!any(last.xyz)) meet(found, numbers.w, facets[3]);
      more = !any(last);
    }
    if (found.denominator > 0.0) {
      record(i, way, found.triangle, kHit + 4u * taken);
      records[3u * count + i] = floatBitsToUint(found.numerator);
      records[4u * count + i] = floatBitsToUint(found.denominator);
      return;
    }
    precise float stride = ahead * grow;
    way = way + stride;
  }
}
)";

// Does the same as launch() (methods/particle/march_job.cpp), in the same order, in double.
constexpr const char* kLaunch = R"(
layout(std140, binding = 0) uniform LaunchParameters {
  dvec4 low, high;    // m, of the box where particles may march
  dvec4 centre;       // m, of the field; and level 0's voxels a metre
  double farthest;    // m
  uint rings, columns;
  uint first;         // particle of the slice, shot after shot
  uint count;         // of the slice
  uint withOrigins;
  uint shotParticles;
  uint shotPoses;
};
layout(std430, binding = 4) writeonly restrict buffer Particles { float particles[]; };

// Stores a number that is computed exactly as on the processor.
void put(uint column, uint i, double value) {
  particles[column * count + i] = float(value);
}

// Stores a number that was computed by a division, which a device may round differently. False if its float32 could
// therefore differ from that of the processor.
bool putQuotient(uint column, uint i, double value) {
  float rounded;
  bool sure = settled(value, 2.0LF * abs(value) * kSlack, rounded);
  particles[column * count + i] = rounded;
  return sure;
}

double inverseOf(double component) {
  return 1.0LF / (abs(component) < 1e-12LF ? 1e-12LF : component);
}

void invoke(uint i) {
  uint shot = (first + i) / shotParticles;
  uint particle = (first + i) % shotParticles;
  uint tile = particle / kTogether;
  uint column = tile / rings * kTogether + particle % kTogether;
  bool there = column < columns;
  column = min(column, columns - 1u);
  dvec3 o, d;
  rayOf(tile % rings * columns + column, column, shot * shotPoses, withOrigins != 0u, o, d);
  precise double begin = 0.0LF;
  precise double end = there ? farthest : 0.0LF;
  for (int k = 0; k < 3; ++k) {
    precise double inverse = inverseOf(d[k]);
    precise double a = (low[k] - o[k]) * inverse;
    precise double b = (high[k] - o[k]) * inverse;
    begin = max(begin, min(a, b));
    end = min(end, max(a, b));
  }
  bool sure = true;
  for (uint k = 0u; k < 3u; ++k) {
    precise double place = (o[k] - centre[k]) * centre.w;
    put(k, i, place);
    put(3u + k, i, d[k]);
    if (kLists) {
      put(8u + k, i, o[k]);
      sure = putQuotient(11u + k, i, inverseOf(d[k])) && sure;
    }
  }
  precise double from = begin * centre.w;
  precise double to = there ? end * centre.w : 0.0LF;
  sure = putQuotient(6u, i, from) && sure;
  sure = putQuotient(7u, i, to) && sure;
  if (!sure) {  // the particle misses at once, and is left to the processor
    put(6u, i, double(kLeftOut));
    put(7u, i, double(kLeftOut));
  }
}
)";

}  // namespace

std::string launchShader(bool lists) {
  return glslConstant("kTogether", ParticleLaunch::kTogether + 0u) + fmt::format("const bool kLists = {};\n", lists) +
         glslConstant("kLeftOut", kLeftOut) + DeviceBeams::shader() + kLaunch;
}

std::string marchShader(bool lists) {
  std::string text = glslConstant("kDistanceStep", kDistanceStep) + glslConstant("kBrickStride", kBrickStride + 0u) +
                     glslConstant("kNoWord", kNoWord) + glslConstant("kFullBrick", kFullBrick) +
                     glslConstant("kLastOfList", kLastOfList) + glslConstant("kNamed", kNamed) +
                     glslConstant("kListed", kListed) + glslConstant("kRest", kRest) +
                     glslConstant("kHit", static_cast<std::uint32_t>(Outcome::Hit)) +
                     glslConstant("kMiss", static_cast<std::uint32_t>(Outcome::Miss)) +
                     glslConstant("kExhausted", static_cast<std::uint32_t>(Outcome::Exhausted)) +
                     glslConstant("kEmptyBend", kEmptyBend) + glslConstant("kNamedBend", kNamedBend) +
                     glslConstant("kListedBend", kListedBend) + glslConstant("kSeam", kSeam) +
                     glslConstant("kBehind", kBehind) + glslConstant("kTie", kTie) + glslConstant("kGoOn", kGoOn) +
                     glslConstant("kNudge", kNudge) + glslConstant("kFace", kFace);
  return text + kCommon + (lists ? kLists : kNearest);
}

}  // namespace scanmill
