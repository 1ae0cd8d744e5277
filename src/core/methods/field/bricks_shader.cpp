#include "methods/field/bricks_shader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#include "gpu/compute.h"
#include "methods/device/traversal_shader.h"
#include "methods/field/brick.h"
#include "methods/field/facet_shader.h"

namespace scanmill {

namespace {

// kCube: what meets the cube around the point is looked for, else what is nearest to it.
constexpr const char* kSearch = R"(
layout(std430, binding = 0) readonly restrict buffer Places { double places[]; };
layout(binding = 0) uniform usamplerBuffer nodes;
layout(binding = 1) uniform usamplerBuffer triangles;

// Where this invocation's brick is, and the point that it looks from.
dvec3 centre;     // m
double voxel;     // m
double perMetre;
vec3 point;       // voxels, from the centre
vec3 metres;      // m
float reach;      // m: of a ball around the point; of a cube, half its side
float square;     // of reach

float longest(vec3 v) {
  vec3 a = abs(v);
  return max(a.x, max(a.y, a.z));
}

// So much farther that nothing is lost to rounding.
void reachTo(float distance) {
  reach = distance + 1e-6 * (longest(metres) + distance);
  square = reach * reach;
}

void lookFrom(uint brick, vec3 at) {
  centre = dvec3(places[5u * brick], places[5u * brick + 1u], places[5u * brick + 2u]);
  voxel = places[5u * brick + 3u];
  perMetre = places[5u * brick + 4u];
  point = at;
  metres = vec3(centre + dvec3(at) * voxel);
}

bool inReach(vec3 low, vec3 high) {
  vec3 gap = max(max(low - metres, metres - high), vec3(0.0));
  return kCube ? longest(gap) <= reach : dot(gap, gap) <= square;
}

// Which children of a node are in reach: bits 24 to 31 nodes, the nearest corner's slot highest; bits 0 to 23 primitives
// of leaves. `after`: where they start; which slots hold nodes, and, from bit 8 on, towards which corner the point lies.
uint meet(uint index, out uvec3 after) {
  int at = int(5u * index);
  uvec4 head = texelFetch(nodes, at);
  uvec4 mid = texelFetch(nodes, at + 1);
  uvec4 a = texelFetch(nodes, at + 2);
  uvec4 b = texelFetch(nodes, at + 3);
  uvec4 c = texelFetch(nodes, at + 4);
  vec3 origin = uintBitsToFloat(head.xyz);
  vec3 scale = uintBitsToFloat(uvec3(head.w & 255u, head.w >> 8 & 255u, head.w >> 16 & 255u) << 23u);
  bvec3 above = greaterThan(metres, planes(uvec3(128u), scale, origin));
  uint side = (above.x ? 1u : 0u) | (above.y ? 2u : 0u) | (above.z ? 4u : 0u);
  after = uvec3(mid.x, mid.y, head.w >> 24 | side << 8);
  uint hits = 0u;
  for (uint half_ = 0u; half_ < 2u; ++half_) {
    bool second = half_ == 1u;
    uint leaf = second ? mid.w : mid.z;
    uvec3 low = second ? uvec3(a.y, a.w, b.y) : uvec3(a.x, a.z, b.x);
    uvec3 high = second ? uvec3(b.w, c.y, c.w) : uvec3(b.z, c.x, c.z);
    for (uint k = 0u; k < 4u; ++k) {
      uint shift = 8u * k;
      uint meta = leaf >> shift & 255u;
      if (meta == 0u) continue;
      if (!inReach(planes(low >> shift & uvec3(255u), scale, origin), planes(high >> shift & uvec3(255u), scale, origin)))
        continue;
      uint slot = 4u * half_ + k;
      hits |= (after.z >> slot & 1u) != 0u ? 0x80000000u >> (slot ^ side) : (meta >> 5) << (meta & 31u);
    }
  }
  return hits;
}

struct Corners {
  uint order;
  dvec3 a, b, c;  // voxels, from the brick's centre
};

// False where the box around the triangle is out of reach.
bool cornersOf(uint primitive, out Corners corners) {
  uvec4 first = texelFetch(triangles, int(3u * primitive));
  vec3 a = uintBitsToFloat(first.xyz);
  vec3 b = uintBitsToFloat(texelFetch(triangles, int(3u * primitive + 1u)).xyz);
  vec3 c = uintBitsToFloat(texelFetch(triangles, int(3u * primitive + 2u)).xyz);
  if (!inReach(min(min(a, b), c), max(max(a, b), c))) return false;
  precise dvec3 p = (dvec3(a) - centre) * perMetre;
  precise dvec3 q = (dvec3(b) - centre) * perMetre;
  precise dvec3 r = (dvec3(c) - centre) * perMetre;
  corners = Corners(first.w, p, q, r);
  return true;
}

void visit(uint primitive);
)";

constexpr const char* kNearest = R"(
uint nearest;
float nearest2;  // voxels^2
bool sure;       // no number was too small

void visit(uint primitive) {
  Corners t;
  if (!cornersOf(primitive, t)) return;
  float distance2 = distance2To(t.a, t.b, t.c, point, sure);
  if (distance2 > nearest2 || (distance2 == nearest2 && t.order >= nearest)) return;
  nearest = t.order;
  nearest2 = distance2;
  reachTo((sqrt(distance2) + 2e-4) * float(voxel));  // as rounded distances are looked at: see reachOf() in nearby.cpp
}

// The nearest triangle up to a distance, voxels.
void findNearest(float limit) {
  nearest = kNoWord;
  nearest2 = limit * limit;
  sure = true;
  reachTo((limit + 2e-4) * float(voxel));
  search(0u);
}
)";

constexpr const char* kCentres = R"(
layout(std430, binding = 1) writeonly restrict buffer Centres { uint centres[]; };

void invoke(uint brick) {
  lookFrom(brick, vec3(0.0));
  findNearest(kFar);
  precise float distance = rootOf(nearest2) * kShort;
  centres[brick] = sure && nearest != kNoWord ? floatBitsToUint(distance) : kLeft;
}
)";

constexpr const char* kBlocks = R"(
layout(std430, binding = 1) writeonly restrict buffer Blocks { uint blocks[]; };

void invoke(uint i) {
  uint block = i % kBlocks;
  lookFrom(i / kBlocks, vec3(uvec3(block % 3u, block / 3u % 3u, block / 9u) * 3u + 1u) - kHalfBrick);
  float seen = kSeen[block];
  findNearest(seen);
  float distance = nearest != kNoWord ? min(rootOf(nearest2), seen) : seen;
  blocks[i] = sure ? floatBitsToUint(distance) : kLeft;
}
)";

constexpr const char* kCornersOf = R"(
uvec3 cornerOf(uint i) {
  return uvec3(i % 9u, i / 9u % 9u, i / 81u);
}
)";

constexpr const char* kCorners = R"(
layout(std430, binding = 1) readonly restrict buffer Blocks { uint blocks[]; };
layout(std430, binding = 2) writeonly restrict buffer Made { uint made[]; };

void invoke(uint i) {
  uint brick = i / kCorners;
  uvec3 corner = cornerOf(i % kCorners);
  uvec3 block = corner / 3u;
  uint ofBlock = blocks[brick * kBlocks + (block.z * 3u + block.y) * 3u + block.x];
  made[2u * i] = kLeft;
  made[2u * i + 1u] = kNoWord;
  if (ofBlock == kLeft) return;
  float blockDistance = uintBitsToFloat(ofBlock);
  uvec3 away = corner % 3u;
  uint aside = (away.x != 1u ? 1u : 0u) + (away.y != 1u ? 1u : 0u) + (away.z != 1u ? 1u : 0u);
  precise float bound = max(blockDistance - kAside[aside] - kRounding, kExact);
  precise float distance = bound;
  if (!(blockDistance > kBlockReach)) {
    lookFrom(brick, vec3(corner) - kHalfBrick);
    findNearest(kExact + 1e-3);
    if (!sure) return;
    float root = rootOf(nearest2);
    precise float shortened = max(root - kRounding, 0.0);
    if (nearest != kNoWord && root <= kExact) distance = shortened;
  }
  precise float steps = distance * kPerStep;
  uint whole = uint(int(steps));
  made[2u * i] = whole;
  made[2u * i + 1u] = whole > kMostNamed ? kNoWord : nearest;
}
)";

constexpr const char* kCubes = R"(
layout(std430, binding = 1) restrict buffer Made { uint made[]; };
layout(std430, binding = 2) restrict buffer Lists { uint lists[]; };

uint listed;
uint begin;

void visit(uint primitive) {
  Corners t;
  if (!cornersOf(primitive, t) || !meetsCube(t.a, t.b, t.c, point)) return;
  if (kFill) lists[begin + listed] = t.order;
  ++listed;
}

void findListed(uint i) {
  listed = 0u;
  lookFrom(i / kCorners, vec3(cornerOf(i % kCorners)) - kHalfBrick);
  reachTo(kReachOfCubes * float(voxel));
  search(0u);
}
)";

constexpr const char* kCounts = R"(
void invoke(uint i) {
  made[2u * i + 1u] = kNoWord;
  if (made[2u * i] > kMostListed) return;
  findListed(i);
  if (listed > 0u) made[2u * i + 1u] = listed;
}
)";

constexpr const char* kLists = R"(
// Lets an entry sink in a heap whose first is the largest.
void sink(uint at, uint size) {
  uint entry = lists[begin + at];
  while (true) {
    uint child = 2u * at + 1u;
    if (child >= size) break;
    if (child + 1u < size && lists[begin + child + 1u] > lists[begin + child]) ++child;
    if (lists[begin + child] <= entry) break;
    lists[begin + at] = lists[begin + child];
    at = child;
  }
  lists[begin + at] = entry;
}

void invoke(uint i) {
  begin = made[2u * i + 1u];
  if (made[2u * i] > kMostListed || begin == kNoWord) return;
  findListed(i);
  if (listed > kMostSorted) return;
  for (uint at = listed / 2u; at > 0u; --at) sink(at - 1u, listed);
  for (uint size = listed; size > 1u; --size) {
    uint last = lists[begin + size - 1u];
    lists[begin + size - 1u] = lists[begin];
    lists[begin] = last;
    sink(0u, size - 1u);
  }
}
)";

template <std::size_t kCount>
std::string floatArray(const char* name, const std::array<float, kCount>& values) {
  std::string list;
  for (const float value : values) {
    list += fmt::format("{}uintBitsToFloat({}u)", list.empty() ? "" : ", ", std::bit_cast<std::uint32_t>(value));
  }
  return fmt::format("#define {} float[]({})\n", name, list);
}

std::string constants(bool cube) {
  constexpr float kMostNearby = 1e15f;  // voxels, of the triangle nearest to a brick
  std::array<float, kBlocksPerBrick> seen{};
  for (std::size_t block = 0; block < seen.size(); ++block) seen[block] = brick::seenFrom(static_cast<int>(block));
  std::array<float, 4> aside{};
  for (std::size_t axes = 0; axes < aside.size(); ++axes) aside[axes] = std::sqrt(static_cast<float>(axes));
  return fmt::format("const bool kCube = {};\n", cube) + glslConstant("kNoWord", kNoWord) +
         glslConstant("kLeft", kLeftBrick) + glslConstant("kBlocks", kBlocksPerBrick) +
         glslConstant("kCorners", kCornersPerBrick + 0u) + glslConstant("kHalfBrick", static_cast<float>(kHalfBrick)) +
         glslConstant("kExact", kExact) + glslConstant("kRounding", brick::kRounding) +
         glslConstant("kBlockReach", kExact + brick::kBlockRadius) + glslConstant("kFar", kMostNearby) +
         glslConstant("kShort", brick::kShortened) + glslConstant("kPerStep", 1 / kDistanceStep) +
         glslConstant("kMostSorted", kMostSorted) +
         glslConstant("kMostNamed", static_cast<std::uint32_t>(kNamed / kDistanceStep)) +
         glslConstant("kMostListed", static_cast<std::uint32_t>(kListed / kDistanceStep)) +
         glslConstant("kReachOfCubes", kListedHalf + 1e-3f) + floatArray("kSeen", seen) + floatArray("kAside", aside);
}

std::string searchShader(bool cube) {
  return constants(cube) + (cube ? cubeShader() : facetShader()) + boundsShader() + kSearch +
         traversalShader(
             {"void search(uint root)", "hits = meet(index, after);", "open.y >> 8 & 7u", "visit(primitive);"});
}

}  // namespace

std::string brickCentresShader() {
  return searchShader(false) + kNearest + kCentres;
}

std::string brickBlocksShader() {
  return searchShader(false) + kNearest + kBlocks;
}

std::string brickCornersShader() {
  return searchShader(false) + kNearest + kCornersOf + kCorners;
}

std::string brickCountsShader() {
  return "const bool kFill = false;\n" + searchShader(true) + kCornersOf + kCubes + kCounts;
}

std::string brickListsShader() {
  return "const bool kFill = true;\n" + searchShader(true) + kCornersOf + kCubes + kLists;
}

}  // namespace scanmill
