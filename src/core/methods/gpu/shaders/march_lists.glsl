// The particles of a subgroup march until each has reached a voxel with a list of triangles; then all test the
// triangles of their lists at the same time. Further tables: lists at binding 4, triangles at binding 5 (three vec4
// each: a corner and the two edges from this corner; m, relative to the world's origin).

#include "march.glsl"

layout(binding = 4) uniform usamplerBuffer lists;
layout(binding = 5) uniform samplerBuffer triangles;

vec3 crossed(vec3 a, vec3 b) {
  precise vec3 product = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return product;
}

struct Facet {
  vec3 a, ab, ac;  // a corner and the two edges from it (m)
};

Facet facetOf(uint triangle) {
  int at = int(3u * triangle);
  return Facet(texelFetch(triangles, at).xyz, texelFetch(triangles, at + 1).xyz, texelFetch(triangles, at + 2).xyz);
}

// A search for the nearest triangle of a list that a particle hits in a voxel.
struct Search {
  vec3 d, position;  // direction (unit vector) and position of the particle (m)
  float low, high;   // limits of a hit's distance from `position` along d (m)
  float tie;        // m; a hit replaces an earlier hit only if it is nearer by more than `tie`
  float numerator, denominator;  // distance of the hit (m) as a fraction; denominator 0: no hit
  uint triangle;
};

// Intersects a particle's line with a triangle (Moeller and Trumbore, see march_stream.h). The new
// hit replaces the hit of `search` if the new hit is nearer by more than `tie`.
void intersect(inout Search search, uint triangle, Facet facet) {
  precise vec3 p = crossed(search.d, facet.ac);
  precise float determinant = dotted(facet.ab, p);
  precise float facing = determinant < 0.0 ? -1.0 : 1.0;
  precise vec3 s = search.position - facet.a;
  precise vec3 q = crossed(s, facet.ab);
  precise float denominator = determinant * facing;
  precise float u = dotted(s, p) * facing;
  precise float v = dotted(search.d, q) * facing;
  precise float t = dotted(facet.ac, q) * facing;
  precise float margin = denominator * kTriangleMargin;
  precise float uv = u + v;
  precise float mostUv = denominator + margin;
  precise float limit = (search.numerator - search.tie * search.denominator) * denominator;
  precise float scaled = t * search.denominator;
  precise float least = search.low * denominator;
  precise float most = search.high * denominator;
  if (denominator > 0.0 && u >= -margin && v >= -margin && uv <= mostUv && t >= least && t <= most &&
      (!(search.denominator > 0.0) || scaled < limit)) {
    search.numerator = t;
    search.denominator = denominator;
    search.triangle = triangle;
  }
}

void invoke(uint i) {
  precise vec3 o = column3(0u, i);
  precise vec3 d = column3(3u, i);
  precise float begin = particles[6u * count + i];
  precise float end = particles[7u * count + i];
  precise vec3 w = column3(8u, i);
  precise vec3 reciprocal = column3(11u, i);
  precise vec3 side = mix(vec3(kExitPlane), vec3(-kExitPlane), lessThan(reciprocal, vec3(0.0)));
  precise float travelled = begin;
  uint taken = 0u;
  if (onlyBehindHoles != 0u) {
    uint before = records[2u * count + i];
    if ((before & 3u) != kPassesHole) return;
    taken = before >> 2;
  }
  while (true) {
    precise float ahead = 0.0;
    float voxelSize = 1.0;
    uint list = kNoTriangle;
    bool listed = false;
    while (!listed) {
      if (taken >= steps || !(travelled < end)) {
        record(i, 0.0, 0u, taken < steps ? kMiss + 4u * taken : kExhausted + 4u * steps);
        return;
      }
      ++taken;
      precise vec3 q = o + d * travelled;
      Voxel v = voxelOf(q, levelAt(q));
      precise float near = v.full ? distanceAt(v.nearest) * kDistanceStep : uintBitsToFloat(v.brick);
      precise vec3 r = v.full ? v.r : v.b;
      float fullChordFactor = near > kNearestLimit ? kNearestChordFactor : kListChordFactor;
      Chord chord = chordOf(near, v.full ? fullChordFactor : kEmptyChordFactor, r, d);
      ahead = chord.across - chord.along;
      voxelSize = v.voxelSize;
      if (v.full) {
        precise vec3 faces = (side - v.r) * reciprocal;
        precise float exit = min(faces.x, min(faces.y, faces.z));
        if (near > kListLimit) {
          ahead = max(ahead, exit);
        } else {
          precise float leaving = chord.square + (2.0 * chord.along + exit) * exit;
          precise float ball = near * near;
          listed = chord.square > ball || leaving > ball;
          ahead = exit;
        }
      }
      if (listed) {
        list = fetch(trianglesOrLists, v.nearest);
      } else {
        precise float stride = ahead * voxelSize;
        travelled = travelled + stride;
      }
    }
    precise float voxel = metres * voxelSize;
    precise vec3 position = w + d * (travelled * metres);
    precise float low = max(-kBackwardTolerance * voxel, (begin - travelled) * metres);
    precise float high = (ahead + kFaceOvershoot) * voxel;
    precise float tie = kTieMargin * voxel;
    Search search = Search(d, position, low, high, tie, 0.0, 0.0, 0u);
    bool more = list != kNoTriangle;
    while (more) {
      // Reads four entries at a time: devices mostly wait for memory, and these loads do not wait for each other.
      // Entries beyond the end of the list are ignored.
      uvec4 entries = uvec4(fetch(lists, list), fetch(lists, list + 1u), fetch(lists, list + 2u),
                            fetch(lists, list + 3u));
      list += 4u;
      uvec4 numbers = entries & ~kLastOfList;
      Facet facets[4] = Facet[](facetOf(numbers.x), facetOf(numbers.y), facetOf(numbers.z), facetOf(numbers.w));
      bvec4 last = greaterThanEqual(entries, uvec4(kLastOfList));
      intersect(search, numbers.x, facets[0]);
      if (!last.x) intersect(search, numbers.y, facets[1]);
      if (!any(last.xy)) intersect(search, numbers.z, facets[2]);
      if (!any(last.xyz)) intersect(search, numbers.w, facets[3]);
      more = !any(last);
    }
    if (search.denominator > 0.0) {
      record(i, travelled, search.triangle, kHit + 4u * taken);
      records[3u * count + i] = floatBitsToUint(search.numerator);
      records[4u * count + i] = floatBitsToUint(search.denominator);
      return;
    }
    precise float stride = ahead * voxelSize;
    travelled = travelled + stride;
  }
}
