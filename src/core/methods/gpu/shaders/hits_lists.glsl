// Resolves hits in fields with lists. The particles have already tested the triangles in the lists.

#include "hits.glsl"

bool resolve(uint i, uint ray, uint word, dvec3 o, dvec3 d) {
  uint triangle = records[count + i];
  float way = uintBitsToFloat(records[i]);
  precise float divisor = uintBitsToFloat(records[4u * count + i]) * metres;
  double exact = double(uintBitsToFloat(records[3u * count + i])) / double(divisor);
  float rest;
  if (exact != 0.0LF && !settled(exact, abs(exact) * kSlack, rest)) {
    leave(ray, kOpen);
    return true;
  }
  if (exact == 0.0LF) rest = 0.0;
  precise float total = way + rest;
  precise double traced = double(total) * voxel;
  Plane plane = planeOf(triangle, d);
  if (triangle >= firstAlpha) {
    bool sure;
    bool open = letsPass(plane, traced, 0.0LF, o, d, sure);
    if (!sure || (open && last != 0u)) {
      leave(ray, kOpen);
      return true;
    }
    if (open) {
      precise float begin = total + max(kBehindHole, total * kBehindHoleShare);
      particles[6u * count + i] = begin;
      records[2u * count + i] = kGoOn | (word & ~3u);
      return false;
    }
  }
  double doubt;
  double range = distanceTo(plane, o, doubt);
  double about = double(float(traced));
  precise double low = about - (trust * about + trust);
  precise double high = about + (trust * about + trust);
  if (range > low + doubt && range < high - doubt) {
    hit(ray, plane, range, doubt, o, d);
  } else if (range < low - doubt || range > high + doubt) {
    hit(ray, plane, range < low ? low : high, 0.0LF, o, d);
  } else {
    leave(ray, kOpen);
  }
  return true;
}
