// Computes the hit of a particle like resolve() (methods/particle/resolve.cpp), in the same order, in double. If
// rounding of a quotient could change a decision, the particle is left to the CPU. Storage buffers: 0 to 3 as in
// rays.glsl; 4 (hit records) and 6 (particles) are the buffers 1 and 0 of march.glsl; 5 as in hit_columns.glsl. Tables:
// 0 to 3 as in hit_columns.glsl.

#include "particles.glsl"
#include "hit_columns.glsl"

layout(std430, binding = 4) restrict buffer HitRecords { uint records[]; };
layout(std430, binding = 6) restrict buffer Particles { float particles[]; };

dvec3 onRay(dvec3 o, dvec3 d, double range) {
  precise dvec3 point = o + d * range;
  return point;
}

// True if the particle ended because its path left the box. `certain` is false if rounding could change this.
bool leftField(dvec3 o, dvec3 d, out bool certain) {
  double pathEnd = 2.0LF * pathLength;
  for (int k = 0; k < 3; ++k) {
    double steep = abs(d[k]) < 1e-12LF ? 1e-12LF : d[k];
    pathEnd = min(pathEnd, max((low[k] - o[k]) / steep, (high[k] - o[k]) / steep));
  }
  certain = abs(pathEnd - pathLength) > 1e-9LF * pathLength;
  return pathEnd < pathLength;
}

void putUnresolvedMiss(uint ray, uint reason) {
  miss(ray);
  putUnresolved(ray, reason);
}

// Records the result of a ray whose particle ended without a hit.
void finish(uint ray, uint outcome, dvec3 o, dvec3 d) {
  if (outcome == kExhausted) {
    putUnresolvedMiss(ray, kStepsUsedUp);
    return;
  }
  bool certain = true;
  bool hasLeftField = coversScene == 0u && leftField(o, d, certain);
  if (!certain) {
    putUnresolved(ray, kRounding);
  } else if (hasLeftField) {
    putUnresolvedMiss(ray, kLeftField);
  } else {
    miss(ray);
  }
}

// Resolves the hit in record `i`. Returns false if the particle continues behind a hole. Defined by the including file.
bool resolve(uint i, uint ray, uint word, dvec3 o, dvec3 d);

void invoke(uint i) {
  uint word = records[2u * count + i];
  if ((word & kDone) != 0u) return;
  uint ray;
  dvec3 o, d;
  if (!particleRay(i, ray, o, d)) return;
  if (particles[6u * count + i] == kLeftToCpu) {
    putUnresolved(ray, kRounding);
  } else if ((word & 3u) == kHit) {
    if (!resolve(i, ray, word, o, d)) return;
  } else {
    finish(ray, word & 3u, o, d);
  }
  records[2u * count + i] = word | kDone;
}
