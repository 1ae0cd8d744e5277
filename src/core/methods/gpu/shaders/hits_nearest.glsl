// Computes the hits in fields without lists, where particles stop at a surface. Further buffers: 4 the levels of the
// field, 5 its table, 6 distances, 7 words.

#include "hits.glsl"

layout(binding = 4) uniform usamplerBuffer levels;
layout(binding = 5) uniform usamplerBuffer table;
layout(binding = 6) uniform usamplerBuffer distances;
layout(binding = 7) uniform usamplerBuffer words;

// Converts a point to the field's frame. Returns false if the result's float32 bits could differ from those that the
// CPU computes.
bool fieldFrame(dvec3 point, double doubt, out vec3 q) {
  precise dvec3 place = (point - centre.xyz) * centre.w;
  bool sure = true;
  for (int k = 0; k < 3; ++k) {
    float rounded;
    sure = settled(place[k], doubt * centre.w, rounded) && sure;
    q[k] = rounded;
  }
  return sure;
}

int levelAt(vec3 q) {
  float most = max(abs(q.x), max(abs(q.y), abs(q.z)));
  int level = 0;
  for (float within = reach; level < lastLevel && most > within; within *= 2.0) ++level;
  return level;
}

double voxelAt(vec3 q) {
  return voxel * double(uintBitsToFloat(uint(127 + levelAt(q)) << 23));
}

struct Spot {
  bool full;
  uint cell;  // index of the voxel's corner with the smallest coordinates
  vec3 f;     // position in the voxel, 0 to 1 along each axis
};

Spot spotAt(vec3 q) {
  int level = levelAt(q);
  uvec4 place = texelFetch(levels, 2 * level);
  uvec4 box = texelFetch(levels, 2 * level + 1);
  float scale = uintBitsToFloat(uint(127 - level) << 23);
  precise vec3 u = max(q * scale + uintBitsToFloat(place.xyz), vec3(0.0));
  uvec3 corner = min(uvec3(u), box.xyz * 8u - 1u);
  uvec3 brick = corner >> 3u;
  uvec3 inside = corner & 7u;
  uint entry = texelFetch(table, int(place.w + (brick.z * box.y + brick.y) * box.x + brick.x)).x;
  Spot spot;
  spot.full = entry >= kFullBrick;
  spot.cell = spot.full ? (entry - kFullBrick) * kBrickStride + (inside.z * 9u + inside.y) * 9u + inside.x : 0u;
  precise vec3 f = u - vec3(corner);
  spot.f = f;
  return spot;
}

float mixed(float a, float b, float t) {
  precise float between = a + (b - a) * t;
  return between;
}

float row(uint corner, float t) {
  return mixed(float(texelFetch(distances, int(corner)).x), float(texelFetch(distances, int(corner + 1u)).x), t);
}

// True if the interpolated distance to a surface is at most `there` voxels. It is larger everywhere in empty bricks.
bool surfaceAt(vec3 q) {
  Spot s = spotAt(q);
  if (!s.full) return false;
  float below = mixed(row(s.cell, s.f.x), row(s.cell + 9u, s.f.x), s.f.y);
  float above = mixed(row(s.cell + 81u, s.f.x), row(s.cell + 90u, s.f.x), s.f.y);
  precise float here = mixed(below, above, s.f.z) * kDistanceStep;
  return here <= float(there);
}

// Returns the triangle stored at the corner nearest to a point, or kNoWord.
uint namedAt(vec3 q) {
  Spot s = spotAt(q);
  uvec3 up = uvec3(greaterThanEqual(s.f, vec3(0.5)));
  return s.full ? texelFetch(words, int(s.cell + (up.z * 9u + up.y) * 9u + up.x)).x : kNoWord;
}

// The triangle and the range at which a particle rests.
struct Rest {
  uint triangle;
  double range, doubt;  // m; `doubt`: bound of the error of `range`
};

uint seenAt(uint triangle, dvec3 place, double doubt, dvec3 d, double size, inout bool sure) {
  dvec3 normal;
  double offset;
  planeRecord(triangle, normal, offset);
  double side = sum3(normal, d) > 0.0LF ? -1.0LF : 1.0LF;
  precise double away = side * aside * size;
  precise dvec3 beside = place + normal * away;
  vec3 q;
  sure = fieldFrame(beside, doubt, q) && sure;
  uint named = namedAt(q);
  if (named == kNoWord || named == triangle) return triangle;
  dvec3 otherNormal;
  double otherOffset;
  planeRecord(named, otherNormal, otherOffset);
  if (!(abs(sum3(otherNormal, normal)) > alike)) return triangle;
  precise double gap = abs(sum3(otherNormal, place) - otherOffset);
  precise double thick = layer * size;
  if (doubt > 0.0LF && abs(gap - thick) <= 2.0LF * doubt) sure = false;
  return gap <= thick ? named : triangle;
}

Rest renamed(Rest rest, dvec3 o, dvec3 d, inout bool sure) {
  dvec3 normal;
  double offset;
  planeRecord(rest.triangle, normal, offset);
  dvec3 here = onRay(o, d, rest.range);
  precise dvec3 onPlane = here + normal * (offset - sum3(normal, here));
  vec3 q;
  sure = fieldFrame(here, 0.0LF, q) && sure;
  rest.triangle = seenAt(rest.triangle, onPlane, 0.0LF, d, voxelAt(q), sure);
  return rest;
}

Rest moved(Rest rest, dvec3 o, dvec3 d, inout bool sure) {
  for (int round = 0; round < 2; ++round) {
    dvec3 normal;
    double offset;
    planeRecord(rest.triangle, normal, offset);
    dvec3 here = onRay(o, d, rest.range);
    double size = (largest(o) + abs(rest.range)) * (4.0LF * kSlack);
    double hereDoubt = rest.doubt > 0.0LF ? rest.doubt + size : 0.0LF;
    precise double away = offset - sum3(normal, here);
    double facing = sum3(normal, d);
    double further = away / facing;
    double range = rest.range + further;
    double doubt = rest.doubt + 4.0LF * hereDoubt / abs(facing) + (abs(further) + abs(range)) * kSlack;
    vec3 q;
    sure = fieldFrame(here, hereDoubt, q) && sure;
    double voxelHere = voxelAt(q);
    precise double limit = trusted * voxelHere;
    bool near = hereDoubt > 0.0LF && abs(abs(away) - limit) <= 4.0LF * hereDoubt;
    if (near || !(abs(range) > doubt)) sure = false;
    if (!(abs(away) <= limit) || !(range >= 0.0LF)) return rest;
    dvec3 place = onRay(o, d, range);
    double placeDoubt = doubt + size + abs(further) * (4.0LF * kSlack);
    if (any(lessThanEqual(min(abs(place - low.xyz), abs(place - high.xyz)), dvec3(placeDoubt)))) sure = false;
    if (any(lessThan(place, low.xyz)) || any(greaterThan(place, high.xyz))) return rest;
    sure = fieldFrame(place, placeDoubt, q) && sure;
    if (!surfaceAt(q)) return rest;
    uint seen = seenAt(rest.triangle, place, placeDoubt, d, voxelHere, sure);
    bool same = seen == rest.triangle;
    rest = Rest(seen, range, doubt);
    if (same) break;
  }
  return rest;
}

bool resolve(uint i, uint ray, uint word, dvec3 o, dvec3 d) {
  precise double way = double(uintBitsToFloat(records[i])) * voxel;
  bool sure = way > 0.0LF;  // hits of particles that start at a surface are computed on the processor
  Rest rest = Rest(records[count + i], way, 0.0LF);
  if (corrected != 0u) {
    rest = moved(rest, o, d, sure);
  } else {
    rest = renamed(rest, o, d, sure);
  }
  float rounded;
  sure = settled(rest.range, rest.doubt, rounded) && sure;
  if (sure) {
    hit(ray, planeOf(rest.triangle, d), double(rounded), 0.0LF, o, d);
  } else {
    leave(ray, kOpen);
  }
  return true;
}
