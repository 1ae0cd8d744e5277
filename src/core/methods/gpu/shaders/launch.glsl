// Creates the particles of a MarchJob by the same operations as launch() (methods/particle/launch.cpp), in the same
// order, in double. Storage buffers: 0 to 3 as in rays.glsl, 4 particles (float columns, in the order of Particles).

#include "particles.glsl"

layout(std430, binding = 4) writeonly restrict buffer Particles { float particles[]; };

// Sets a particle's value in a column. The device and the CPU must compute the same bits for `value`.
void put(uint column, uint i, double value) {
  particles[column * count + i] = float(value);
}

// Like put(), for a value that was computed by a division, which a device may round differently. Returns false if the
// stored float32 could therefore differ from the CPU's.
bool putQuotient(uint column, uint i, double value) {
  float rounded;
  bool certain = roundsAlike(value, 2.0LF * abs(value) * kSlack, rounded);
  particles[column * count + i] = rounded;
  return certain;
}

double inverseOf(double component) {
  return 1.0LF / (abs(component) < 1e-12LF ? 1e-12LF : component);
}

void invoke(uint i) {
  uint ray;
  dvec3 o, d;
  bool hasRay = particleRay(i, ray, o, d);
  precise double begin = 0.0LF;  // m, section of the ray that is inside of the box
  precise double end = hasRay ? pathLength : 0.0LF;
  for (int k = 0; k < 3; ++k) {
    precise double inverse = inverseOf(d[k]);
    precise double a = (low[k] - o[k]) * inverse;
    precise double b = (high[k] - o[k]) * inverse;
    begin = max(begin, min(a, b));
    end = min(end, max(a, b));
  }
  bool certain = true;
  for (uint k = 0u; k < 3u; ++k) {
    precise double origin = (o[k] - centre[k]) * centre.w;
    put(k, i, origin);
    put(3u + k, i, d[k]);
    if (kLists) {
      put(8u + k, i, o[k]);
      certain = putQuotient(11u + k, i, inverseOf(d[k])) && certain;
    }
  }
  precise double fieldBegin = begin * centre.w;
  precise double fieldEnd = hasRay ? end * centre.w : 0.0LF;
  certain = putQuotient(6u, i, fieldBegin) && certain;
  certain = putQuotient(7u, i, fieldEnd) && certain;
  if (!certain) {  // the particle misses at once, and is left to the CPU
    put(6u, i, double(kLeftToCpu));
    put(7u, i, double(kLeftToCpu));
  }
}
