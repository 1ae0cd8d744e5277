// The steps of march_stream.h. Values marked `precise` are neither contracted nor reassociated, so they have the same
// bits as on the CPU. Divisions, which GPUs round differently, do not occur.
//
// Storage buffers: 0 particles (float columns, in the order of Particles), 1 hit records (uint columns: bits of the
// distance, triangle, outcome; with lists also the bits of a numerator and a denominator, whose quotient (m) must be
// added to the distance). Tables: 0 the field's levels (two uvec4 each: bits of the offset and the first entry, then
// the numbers of bricks), 1 the field's table, 2 its distances, 3 its words.

// Must have the same members as the struct MarchParameters in device_march.cpp.
layout(std140, binding = 0) uniform MarchParameters {
  int lastLevel;
  float perReach;
  float metres;
  uint steps;
  uint count;
  uint again;  // 1: marches only particles that continue behind a hole
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

void record(uint i, float travelled, uint triangle, uint outcome) {
  records[i] = floatBitsToUint(travelled);
  records[count + i] = triangle;
  records[2u * count + i] = outcome;
}

struct Voxel {
  float scale, voxelSize;
  vec3 f;  // position in the voxel
  vec3 r;  // position relative to the nearest corner
  vec3 b;  // position relative to the brick's centre
  bool full;
  uint brick, cell, nearest;
};

Voxel find(vec3 q) {
  precise float most = max(abs(q.x), max(abs(q.y), abs(q.z)));
  precise float share = most * perReach;
  int level = min(max((int(floatBitsToUint(share) - 1u) >> 23) - 126, 0), lastLevel);
  uvec4 place = texelFetch(levels, 2 * level);  // xyz: bits of the offset; w: index of the level's first entry
  uvec4 box = texelFetch(levels, 2 * level + 1);
  Voxel v;
  v.scale = uintBitsToFloat(uint(127 - level) << 23);
  v.voxelSize = uintBitsToFloat(uint(127 + level) << 23);
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

// The chord along which a particle's line crosses a free ball.
struct Chord {
  float square;  // squared distance of the particle from the ball's centre
  float along;   // length from the middle of the chord to the particle
  float across;  // lower bound of half the chord's length
};

Chord chordOf(float radius, float chordFactor, vec3 r, vec3 d) {
  precise float square = dotted(r, r);
  precise float along = dotted(r, d);
  precise float most = radius - (square - along * along) * chordFactor;
  return Chord(square, along, most);
}
