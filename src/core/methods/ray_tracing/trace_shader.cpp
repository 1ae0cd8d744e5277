#include <fmt/format.h>

#include <limits>
#include <string>

#include "gpu/compute.h"
#include "methods/device/device_beams.h"
#include "methods/device/device_resolver.h"
#include "methods/device/traversal_shader.h"
#include "methods/ray_tracing/filter.h"
#include "methods/ray_tracing/gl_tracer.h"

namespace scanmill {

namespace {

constexpr const char* kRays = R"(
layout(std140, binding = 0) uniform TraceParameters {
  uint columns;       // of the table of beams
  uint sliceRings;
  uint shotRays;      // of a shot
  uint shotPoses;
  uint rays;          // of all shots
  uint meshRoot;      // of what is baked; kNoRoot where nothing is
  uint placesRoot;    // kNoRoot where nothing is placed
  uint withOrigins;
  uint moves;         // 1: something moves during the revolution
  float farthest;     // m, how far rays go
  float coplanar;     // m, within which surfaces tie beside their share of the distance
  float splitDoubt;   // share of the origin's distance by which boxes around parts of triangles may be off
};
layout(std430, binding = 5) writeonly restrict buffer Found { uint found[]; };
layout(binding = 0) uniform usamplerBuffer nodes;
layout(binding = 1) uniform usamplerBuffer triangles;
layout(binding = 2) uniform usamplerBuffer cutouts;
layout(binding = 3) uniform usamplerBuffer holes;
layout(binding = 4) uniform usamplerBuffer placeNodes;
layout(binding = 5) uniform usamplerBuffer places;

// A ray in the frame of the triangles that it is to meet. Its parameter is m in the world.
struct Line {
  vec3 o, d;
  vec3 inverse;  // of d
  uint signs;    // bit k: d is negative along axis k
  vec3 doubt;    // m in this frame, by how much o may be off
  vec3 turned;   // by how much d may be
  float corners; // share by which what leads from o to a corner may be off
};

// What one invocation has found so far.
vec3 worldDirection;
float part;       // of the revolution
float best;       // m; infinite: nothing
float bestOff;    // m, by how much it may be off along the ray
float bestCosine;
uint bestTriangle, bestPlace;
float unsure;     // m, the least distance at which something may or may not be the first that the ray meets
float reach;      // m, how far to look on

float longest(vec3 v) {
  vec3 a = abs(v);
  return max(a.x, max(a.y, a.z));
}

Line lineOf(vec3 o, vec3 d, vec3 doubt, vec3 turned, float corners) {
  vec3 steep = mix(d, mix(vec3(kLeast), vec3(-kLeast), lessThan(d, vec3(0.0))), lessThan(abs(d), vec3(kLeast)));
  uint signs = (steep.x < 0.0 ? 1u : 0u) | (steep.y < 0.0 ? 2u : 0u) | (steep.z < 0.0 ? 4u : 0u);
  return Line(o, d, vec3(1.0) / steep, signs, doubt, turned, corners);
}

void doubtAt(float distance) {
  unsure = min(unsure, max(distance, 0.0));
}

// Which children of a node the line meets within reach: bits 24 to 31 nodes, by the order in which it meets them, the
// first highest; bits 0 to 23 primitives of leaves. `after`: where they start, and which slots hold nodes.
uint meet(usamplerBuffer from, uint index, Line line, out uvec3 after) {
  int at = int(5u * index);
  uvec4 head = texelFetch(from, at);
  uvec4 mid = texelFetch(from, at + 1);
  uvec4 a = texelFetch(from, at + 2);
  uvec4 b = texelFetch(from, at + 3);
  uvec4 c = texelFetch(from, at + 4);
  after = uvec3(mid.x, mid.y, head.w >> 24);
  vec3 origin = uintBitsToFloat(head.xyz);
  vec3 scale = uintBitsToFloat(uvec3(head.w & 255u, head.w >> 8 & 255u, head.w >> 16 & 255u) << 23u);
  // What is met there may be off by as much as triangles are: see meetTriangle().
  float away = longest(max(abs(origin - line.o), abs(planes(uvec3(255u), scale, origin) - line.o)));
  vec3 blur = (line.doubt + (kRounding + 2.0 * line.turned / length(line.d)) * away) * abs(line.inverse);
  bvec3 negative = bvec3((line.signs & 1u) != 0u, (line.signs & 2u) != 0u, (line.signs & 4u) != 0u);
  uint hits = 0u;
  for (uint half_ = 0u; half_ < 2u; ++half_) {
    bool second = half_ == 1u;
    uint leaf = second ? mid.w : mid.z;
    uvec3 low = second ? uvec3(a.y, a.w, b.y) : uvec3(a.x, a.z, b.x);
    uvec3 high = second ? uvec3(b.w, c.y, c.w) : uvec3(b.z, c.x, c.z);
    uvec3 near = uvec3(negative.x ? high.x : low.x, negative.y ? high.y : low.y, negative.z ? high.z : low.z);
    uvec3 far = uvec3(negative.x ? low.x : high.x, negative.y ? low.y : high.y, negative.z ? low.z : high.z);
    for (uint k = 0u; k < 4u; ++k) {
      uint shift = 8u * k;
      uint meta = leaf >> shift & 255u;
      vec3 enter = (planes(near >> shift & uvec3(255u), scale, origin) - line.o) * line.inverse - blur;
      vec3 leave = (planes(far >> shift & uvec3(255u), scale, origin) - line.o) * line.inverse + blur;
      float first = max(max(enter.x, enter.y), max(enter.z, 0.0)) * kSooner;
      float last = min(min(leave.x, leave.y), min(leave.z, reach)) * kLater;
      if (meta == 0u || first > last) continue;
      uint slot = 4u * half_ + k;
      hits |= (after.z >> slot & 1u) != 0u ? 0x80000000u >> (slot ^ line.signs) : (meta >> 5) << (meta & 31u);
    }
  }
  return hits;
}

// Whether the texture lets a ray pass at barycentric coordinates, which may be off by `blur`; `sure` is false where it
// lets some of the texels pass on which the ray may lie, or where these are too many.
bool passes(uint cutout, vec2 at, vec2 blur, out bool sure) {
  uvec4 ab = texelFetch(cutouts, int(2u * cutout));
  uvec4 rest = texelFetch(cutouts, int(2u * cutout + 1u));
  vec2 a = uintBitsToFloat(ab.xy);
  vec2 b = uintBitsToFloat(ab.zw);
  vec2 c = uintBitsToFloat(rest.xy);
  vec2 uv = a * (1.0 - at.x - at.y) + b * at.x + c * at.y;
  vec2 off = abs(b - a) * blur.x + abs(c - a) * blur.y + kRounding * (abs(a) + abs(b) + abs(c) + 1.0);
  ivec2 size = ivec2(rest.z & 0xFFFFu, rest.z >> 16);
  vec2 place = (uv - floor(uv)) * vec2(size);
  vec2 around = off * vec2(size);
  sure = all(lessThan(around, vec2(kMostTexels)));
  if (!sure) return false;
  ivec2 low = ivec2(floor(place - around));
  ivec2 high = ivec2(floor(place + around));
  bool open = false;
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
      ivec2 texel = (ivec2(x, y) + int(kMostTexels) * size) % size;  // textures repeat
      uint number = uint(texel.y * size.x + texel.x);
      bool here = (texelFetch(holes, int(rest.w + number / 32u)).x >> (number % 32u) & 1u) != 0u;
      if (x == low.x && y == low.y) open = here;
      if (here != open) sure = false;
    }
  }
  return open;
}

// The sizes of the products of a cross product, component by component.
vec3 products(vec3 a, vec3 b) {
  return abs(a.yzx * b.zxy) + abs(a.zxy * b.yzx);
}

// By how much the volume of the edge from q to p may differ here and in Embree. Both begin with the same triangle, and
// lose up to seven units of 2^-24 of each product; where o may be off, both ends are.
float marginOf(vec3 p, vec3 q, Line line) {
  vec3 edge = p - q;
  return dot(abs(line.d) * kRounding + line.turned, products(edge, p + q)) +
         dot(abs(line.d), products(edge, 2.0 * line.doubt + line.corners * (abs(p) + abs(q))));
}

// Meets a triangle by the volumes that the ray makes with its edges (T. Davidovic, T. Engelhardt, I. Georgiev, P.
// Slusallek, C. Dachsbacher, "3D rasterization: a bridge between rasterization and ray casting", 2012): signs alone
// decide, so that no ray passes between two triangles. Each volume is twice the edge's length times how far the ray
// passes it: where that is within rounding, the ray is unsure. `toNormal`: rows that turn a normal into the world.
void meetTriangle(uint t, Line line, uint place, mat3 toNormal) {
  uvec4 wordsA = texelFetch(triangles, int(3u * t));
  uvec4 wordsB = texelFetch(triangles, int(3u * t + 1u));
  precise vec3 a = uintBitsToFloat(wordsA.xyz) - line.o;
  precise vec3 b = uintBitsToFloat(wordsB.xyz) - line.o;
  precise vec3 c = uintBitsToFloat(texelFetch(triangles, int(3u * t + 2u)).xyz) - line.o;
  precise vec3 e0 = c - a;
  precise vec3 e1 = a - b;
  precise vec3 e2 = b - c;
  precise vec3 volumes = vec3(dot(cross(e0, c + a), line.d), dot(cross(e1, a + b), line.d),
                              dot(cross(e2, b + c), line.d));
  float along = max(longest(a), max(longest(b), longest(c)));
  float doubt = longest(line.doubt) + (kRounding + 2.0 * longest(line.turned) / length(line.d)) * along;
  vec3 margin = vec3(marginOf(c, a, line), marginOf(a, b, line), marginOf(b, c, line)) +
                kInside * abs(volumes.x + volumes.y + volumes.z);
  bool front = any(greaterThan(volumes, margin));
  bool back = any(lessThan(volumes, -margin));
  if (front && back) return;
  vec3 normal = cross(e0, e1);
  float facing = dot(normal, line.d);
  float square = dot(line.d, line.d);
  bool met = all(greaterThanEqual(volumes, margin)) || all(lessThanEqual(volumes, -margin));
  vec3 corners = vec3(dot(a, line.d), dot(b, line.d), dot(c, line.d)) / square;
  float slack = doubt / sqrt(square);
  float nearest = min(corners.x, min(corners.y, corners.z)) - slack;
  float farther = max(corners.x, max(corners.y, corners.z)) + slack;
  if (farther < 0.0 || nearest > reach) return;
  float distance = dot(a, normal) / facing;
  float edge = sqrt(max(dot(e0, e0), max(dot(e1, e1), dot(e2, e2))));
  float off = (doubt * length(normal) + kRounding * length(products(e0, e1)) * edge) / abs(facing);
  if (!met || !(off < kInfinite)) {
    // The ray meets the plane where it passes the edge, if it meets the triangle at all.
    bool plane = distance >= nearest && distance <= farther && off < farther - nearest;
    float least = plane ? max(nearest, distance - 2.0 * off) : nearest;
    if (least <= reach) doubtAt(least);
    return;
  }
  if (distance < -off || distance - off > reach) return;
  if (distance < off) {
    doubtAt(0.0);
    return;
  }
  if (wordsB.w != 0u) {
    bool sure;
    float sum = volumes.x + volumes.y + volumes.z;
    bool open = passes(wordsB.w - 1u, volumes.xy / sum, vec2(margin.x + margin.y + margin.z) / abs(sum), sure);
    if (!sure) {
      doubtAt(distance - off);
      return;
    }
    if (open) return;
  }
  vec3 turned = vec3(dot(toNormal[0], normal), dot(toNormal[1], normal), dot(toNormal[2], normal));
  float cosine = abs(dot(turned, worldDirection)) / length(turned);
  if (off > kTrusted * (1.0 + distance) || distance + off > farthest) doubtAt(distance - off);
  float gap = abs(distance - best);
  if (gap <= off + bestOff + 2.0 * (kCoplanar * distance + coplanar) / max(cosine, bestCosine)) {
    doubtAt(min(distance - off, best - bestOff));
  }
  if (!(distance < best)) return;
  best = distance;
  bestOff = off;
  bestCosine = cosine;
  bestTriangle = wordsA.w;
  bestPlace = place;
  reach = min(reach, best * (1.0 + kReach) + coplanar + 2.0 * off + 4.0 * (kCoplanar * best + coplanar) / cosine);
}
)";

constexpr const char* kEnter = R"(
// Takes the ray into the frame of a placed mesh. Embree does so by the inverse of the matrix in float32: cofactors over
// the determinant, which lose up to 8 units of 2^-24 of their products each, and so does the ray's way to where the mesh
// stands; then products with the matrix, which lose 9, and boxes, which lose 4 (they are not made robust where meshes
// are placed). Of what moves Embree mixes two matrices first, and here the inverse is in float32, too.
void enter(uint number, Line line) {
  int at = int(7u * number);
  uvec4 words = texelFetch(places, at + 6);
  bool moving = words.z != 0u;
  vec4 row[3], most[3];  // of the matrix, or of its inverse where it stands still; and its largest elements on the way
  for (int k = 0; k < 3; ++k) {
    row[k] = uintBitsToFloat(texelFetch(places, at + k));
    most[k] = abs(row[k]);
    if (moving) {
      vec4 last = uintBitsToFloat(texelFetch(places, at + 3 + k));
      most[k] = max(most[k], abs(last));
      row[k] += (last - row[k]) * part;
    }
  }
  vec3 linear[3] = vec3[](row[0].xyz, row[1].xyz, row[2].xyz);
  vec3 cofactor[3] = vec3[](cross(linear[1], linear[2]), cross(linear[2], linear[0]), cross(linear[0], linear[1]));
  vec3 other[3];
  float determinant = dot(linear[0], cofactor[0]);
  for (int k = 0; k < 3; ++k) other[k] = vec3(cofactor[0][k], cofactor[1][k], cofactor[2][k]) / determinant;
  vec3 translation = vec3(row[0].w, row[1].w, row[2].w);
  vec3 inverse[3] = linear;
  vec3 stands, far;  // where, in the world, and how far at most
  vec3 sizes[3];     // of the matrix's elements
  if (moving) {
    inverse = other;
    stands = translation;
    far = vec3(most[0].w, most[1].w, most[2].w);
    translation = vec3(-dot(inverse[0], stands), -dot(inverse[1], stands), -dot(inverse[2], stands));
    sizes = vec3[](most[0].xyz, most[1].xyz, most[2].xyz);
  } else {
    stands = uintBitsToFloat(texelFetch(places, at + 3).xyz);
    far = abs(stands);
    determinant = 1.0 / determinant;
    for (int k = 0; k < 3; ++k) sizes[k] = abs(other[k]);
  }
  vec3 size[3] = vec3[](products(sizes[1], sizes[2]), products(sizes[2], sizes[0]), products(sizes[0], sizes[1]));
  float spread = dot(sizes[0], size[0]) / abs(determinant);
  if (!(spread < kMostSpread)) {  // nearly flat
    doubtAt(0.0);
    return;
  }
  mat3 rows = mat3(inverse[0], inverse[1], inverse[2]);  // in columns
  vec3 o = line.o * rows + translation;
  vec3 d = line.d * rows;
  bool exact = !moving;  // but for the quotient 1 / 1: the mesh stands along the axes
  for (int k = 0; k < 3; ++k) exact = exact && all(equal(abs(inverse[k]) * (1.0 - abs(inverse[k])), vec3(0.0)));
  float ofMatrix = (exact ? 4.0 : moving ? 32.0 + 40.0 * spread : 8.0 + 8.0 * spread) * kUnit;
  float ofProducts = (exact ? 4.0 : moving ? 32.0 : 16.0) * kUnit;
  vec3 doubt, turned;
  for (int k = 0; k < 3; ++k) {
    vec3 whole = exact ? abs(inverse[k]) : vec3(size[0][k], size[1][k], size[2][k]) / abs(determinant);
    doubt[k] = ofMatrix * dot(whole, abs(line.o - stands)) + ofProducts * dot(whole, abs(line.o) + far) +
               splitDoubt * longest(o);
    turned[k] = (ofMatrix + 4.0 * kUnit) * dot(whole, abs(line.d));
  }
  // The inverse's transpose turns normals: its rows are the columns of `rows`.
  mat3 toNormal = mat3(rows[0].x, rows[1].x, rows[2].x, rows[0].y, rows[1].y, rows[2].y, rows[0].z, rows[1].z,
                       rows[2].z);
  traverseMesh(words.x, lineOf(o, d, doubt, turned, 4.0 * kUnit), words.y + 1u, toNormal);
}
)";

constexpr const char* kInvoke = R"(
// Invocations that run together take eight neighbouring columns of four rings.
void invoke(uint i) {
  uint across = (columns + 7u) / 8u;
  uint tiles = across * ((sliceRings + 3u) / 4u);
  uint shot = i / (32u * tiles);
  uint tile = i / 32u % tiles;
  uint row = tile / across * 4u + (i % 32u) / 8u;
  uint column = tile % across * 8u + i % 8u;
  if (row >= sliceRings || column >= columns) return;
  uint ray = row * columns + column;
  dvec3 exactOrigin, exactDirection;
  rayOf(ray, column, shot * shotPoses, withOrigins != 0u, exactOrigin, exactDirection);
  vec3 o = vec3(exactOrigin);
  vec3 d = vec3(mix(exactDirection, dvec3(0.0LF), lessThan(abs(exactDirection), dvec3(1e-12LF))));  // see packet.cpp
  worldDirection = d;
  part = moves != 0u ? parts[ray] : 0.0;
  best = kInfinite;
  bestOff = 0.0;
  bestCosine = 0.0;
  bestTriangle = kNothing;
  bestPlace = 0u;
  unsure = kInfinite;
  reach = farthest;
  // The processor rounds the ray to the same float32, and only then takes it into other frames.
  if (meshRoot != kNoRoot) traverseMesh(meshRoot, lineOf(o, d, vec3(splitDoubt * longest(o)), vec3(0.0), 0.0), 0u, mat3(1.0));
  if (placesRoot != kNoRoot) traversePlaces(placesRoot, lineOf(o, d, vec3(kRounding * longest(o)), vec3(0.0), 0.0));
  bool known = !(unsure <= reach);
  uint at = shot * shotRays + ray;
  found[at] = known ? bestTriangle : kUnsure;
  found[rays + at] = bestPlace;
}
)";

}  // namespace

std::string resolveShader() {
  return glslConstant("kNothing", kNothingFound) + glslConstant("kUnsure", kUnsureHit) + DeviceBeams::shader() +
         DeviceResolver::shader("uint columns, shotRays, shotPoses, withOrigins, moves;") + R"(
layout(std430, binding = 5) readonly restrict buffer Found { uint found[]; };

void invoke(uint i) {
  uint triangle = found[i];
  if (triangle == kUnsure) {
    leave(i, kOpen);
    return;
  }
  if (triangle == kNothing) {
    miss(i);
    return;
  }
  uint ray = i % shotRays;
  dvec3 o, d;
  rayOf(ray, ray % columns, i / shotRays * shotPoses, withOrigins != 0u, o, d);
  Plane plane = planeOf(triangle, found[rays + i], moves != 0u ? parts[ray] : 0.0, o, d);
  double doubt;
  double range = distanceTo(plane, o, doubt);
  hit(i, plane, range, doubt, o, d);
}
)";
}

std::string traceShader() {
  constexpr float kUnit = 0x1p-24f;  // half of the step of numbers near 1
  const std::string constants =
      glslConstant("kNoRoot", kNoRoot) + glslConstant("kNothing", kNothingFound) + glslConstant("kUnsure", kUnsureHit) +
      glslConstant("kCoplanar", kCoplanar) + glslConstant("kReach", kReach) + glslConstant("kLeast", 1e-18f) +
      glslConstant("kSooner", 1 - 16 * kUnit) + glslConstant("kLater", 1 + 16 * kUnit) +
      glslConstant("kRounding", 16 * kUnit) + glslConstant("kUnit", kUnit) + glslConstant("kMostSpread", 1e4f) +
      // Embree takes volumes for positive that are so little less, of their sum: 2 units.
      glslConstant("kInside", 4 * kUnit) + glslConstant("kTrusted", 5e-3f) + glslConstant("kMostTexels", 4.0f) +
      glslConstant("kInfinite", std::numeric_limits<float>::infinity());
  // A slot's number differs from the ray's signs by how late the ray meets it.
  const auto traversal = [](const std::string& head, const std::string& nodes, const std::string& leaf) {
    return traversalShader({head, "hits = meet(" + nodes + ", index, line, after);", "line.signs", leaf});
  };
  return constants + DeviceBeams::shader() + boundsShader() + kRays +
         traversal("void traverseMesh(uint root, Line line, uint place, mat3 toNormal)", "nodes",
                   "meetTriangle(primitive, line, place, toNormal);") +
         kEnter + traversal("void traversePlaces(uint root, Line line)", "placeNodes", "enter(primitive, line);") +
         kInvoke;
}

}  // namespace scanmill
