// Computes hits in fields without lists, where particles stop at a surface. Tables: 4 to 6 as in field.glsl.

#include "resolve.glsl"

#define kLevelsBinding 4
#define kTableBinding 5
#define kTrianglesBinding 6
#include "field.glsl"

// Converts a point to the field's frame. Returns false if the float32 result could have other bits than on the CPU.
bool fieldFrame(dvec3 point, out vec3 q) {
  precise dvec3 place = (point - centre.xyz) * centre.w;
  bool certain = true;
  for (int k = 0; k < 3; ++k) {
    float rounded;
    certain = roundsAlike(place[k], 0.0LF, rounded) && certain;
    q[k] = rounded;
  }
  return certain;
}

int levelAt(vec3 q) {
  float largest = max(abs(q.x), max(abs(q.y), abs(q.z)));
  int level = 0;
  for (float within = reach; level < lastLevel && largest > within; within *= 2.0) ++level;
  return level;
}

double voxelSizeAt(vec3 q) {
  return voxel * double(uintBitsToFloat(uint(127 + levelAt(q)) << 23));
}

// Returns the triangle stored at the corner nearest to the point `q`; kNoTriangle in a brick that is not full.
uint triangleAt(vec3 q) {
  Voxel v = voxelOf(q, levelAt(q));
  return v.full ? fetch(trianglesOrLists, v.nearest) : kNoTriangle;
}

// Returns `triangle`, or a triangle of a thin layer on it, like triangleOrLayer() in methods/particle/resolve.cpp.
uint triangleOrLayer(uint triangle, double range, dvec3 o, dvec3 d, inout bool certain) {
  dvec3 normal;
  double offset;
  planeRecord(triangle, normal, offset);
  dvec3 here = onRay(o, d, range);
  precise dvec3 onPlane = here + normal * (offset - sum3(normal, here));
  vec3 q;
  certain = fieldFrame(here, q) && certain;
  double size = voxelSizeAt(q);
  double side = sum3(normal, d) > 0.0LF ? -1.0LF : 1.0LF;
  precise double away = side * layerLookupOffset * size;
  precise dvec3 inFront = onPlane + normal * away;
  certain = fieldFrame(inFront, q) && certain;
  uint other = triangleAt(q);
  if (other == kNoTriangle || other == triangle) return triangle;
  dvec3 otherNormal;
  double otherOffset;
  planeRecord(other, otherNormal, otherOffset);
  if (!(abs(sum3(otherNormal, normal)) > layerMinCosine)) return triangle;
  precise double gap = abs(sum3(otherNormal, onPlane) - otherOffset);
  precise double thick = layerThickness * size;
  return gap <= thick ? other : triangle;
}

bool resolve(uint i, uint ray, uint word, dvec3 o, dvec3 d) {
  precise double range = double(uintBitsToFloat(records[i])) * voxel;
  bool certain = range > 0.0LF;  // hits of particles that start at a surface are computed on the CPU
  uint triangle = triangleOrLayer(records[count + i], range, o, d, certain);
  float rounded;
  certain = roundsAlike(range, 0.0LF, rounded) && certain;
  if (certain) {
    hit(ray, planeOf(triangle, d), double(rounded), 0.0LF, o, d);
  } else {
    putUnresolved(ray, kRounding);
  }
  return true;
}
