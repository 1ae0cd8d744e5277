// Resolves hits in fields with lists. The particles have already tested the triangles in the lists.

#include "resolve.glsl"

bool resolve(uint i, uint ray, uint word, dvec3 o, dvec3 d) {
  uint triangle = records[count + i];
  float travelled = uintBitsToFloat(records[i]);
  precise float divisor = uintBitsToFloat(records[4u * count + i]) * metres;
  double exact = double(uintBitsToFloat(records[3u * count + i])) / double(divisor);
  float lengthToHit;
  if (exact != 0.0LF && !roundsAlike(exact, abs(exact) * kSlack, lengthToHit)) {
    putUnresolved(ray, kRounding);
    return true;
  }
  if (exact == 0.0LF) lengthToHit = 0.0;
  precise float total = travelled + lengthToHit;
  precise double traced = double(total) * voxel;
  Plane plane = planeOf(triangle, d);
  if (triangle >= firstAlpha) {
    bool certain;
    bool open = letsPass(plane, traced, 0.0LF, o, d, certain);
    if (!certain || (open && last != 0u)) {
      putUnresolved(ray, kRounding);
      return true;
    }
    if (open) {
      precise float begin = total + max(kHoleSkip, total * kHoleSkipShare);
      particles[6u * count + i] = begin;
      records[2u * count + i] = kPassesHole | (word & ~3u);
      return false;
    }
  }
  double errorBound;
  double range = distanceTo(plane, o, errorBound);
  double tracedRange = double(float(traced));
  precise double low = tracedRange - (rangeErrorBound * tracedRange + rangeErrorBound);
  precise double high = tracedRange + (rangeErrorBound * tracedRange + rangeErrorBound);
  if (range > low + errorBound && range < high - errorBound) {
    hit(ray, plane, range, errorBound, o, d);
  } else if (range < low - errorBound || range > high + errorBound) {
    hit(ray, plane, range < low ? low : high, 0.0LF, o, d);
  } else {
    putUnresolved(ray, kRounding);
  }
  return true;
}
