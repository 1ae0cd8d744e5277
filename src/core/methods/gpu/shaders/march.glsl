// Marches particles by the steps of march_stream.h. Values marked `precise` are neither contracted nor reassociated, so
// they have the same bits as on the CPU. There are no divisions, because GPUs round them differently.
//
// Storage buffers: 0 particles (float columns, in the order of Particles), 1 hit records (uint columns: bits of the
// distance, triangle, outcome; with lists also the bits of a numerator and a denominator, whose quotient (m) must be
// added to the distance). Tables: 0, 1 and 3 as in field.glsl, 2 the field's distances.

// Must have the same members as the struct MarchParameters in device_march.cpp.
layout(std140, binding = 0) uniform MarchParameters {
  int lastLevel;
  float perReach;
  float metres;
  uint steps;
  uint count;
  uint onlyBehindHoles;  // 1: marches only particles that continue behind a hole
};
layout(std430, binding = 0) readonly restrict buffer Particles { float particles[]; };
layout(std430, binding = 1) restrict buffer HitRecords { uint records[]; };
#define kLevelsBinding 0
#define kTableBinding 1
layout(binding = 2) uniform usamplerBuffer distances;
#define kTrianglesBinding 3
#include "field.glsl"

vec3 column3(uint column, uint i) {
  return vec3(particles[column * count + i], particles[(column + 1u) * count + i],
              particles[(column + 2u) * count + i]);
}

void record(uint i, float travelled, uint triangle, uint outcome) {
  records[i] = floatBitsToUint(travelled);
  records[count + i] = triangle;
  records[2u * count + i] = outcome;
}

// Returns the level used at the point `q` (field's frame). ParticleStream::locateVoxels() explains the computation.
int levelAt(vec3 q) {
  precise float largest = max(abs(q.x), max(abs(q.y), abs(q.z)));
  precise float share = largest * perReach;
  return min(max((int(floatBitsToUint(share) - 1u) >> 23) - 126, 0), lastLevel);
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
  precise float across = radius - (square - along * along) * chordFactor;
  return Chord(square, along, across);
}
